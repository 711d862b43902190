// SPDX-License-Identifier: MIT
// The coarse clock is timer 0 at clk/64: one count is a unit, and the timer overflows every 256
// units (1.024 ms at 16 MHz).
#include "hal/clock.h"

#include <avr/interrupt.h>
#include <avr/io.h>
#include <stdbool.h>

static volatile uint32_t timer0_overflows;

// Budget: 70 cycles, once a millisecond. The step interrupts are let in at once.
ISR(TIMER0_OVF_vect, ISR_NOBLOCK)
{
    timer0_overflows++;
}

void clock_start(void)
{
    TCCR0A = 0;
    TCCR0B = (uint8_t)(_BV(CS01) | _BV(CS00));
    TIMSK0 = (uint8_t)_BV(TOIE0);
}

// The overflow interrupt may still wait behind step interrupts although the count has wrapped, so
// that its flag is read too. If the interrupt is served between the reads, they are repeated, which
// needs no time with interrupts off.
uint32_t clock_now_units(void)
{
    uint32_t high = 0;
    uint8_t low = 0;
    bool pending = false;

    do {
        high = timer0_overflows;
        low = TCNT0;
        pending = (TIFR0 & _BV(TOV0)) != 0;
    } while (high != timer0_overflows);
    // A large count was read before the wrap: the flag was then set between the two reads.
    if (pending && low < 128u) {
        high++;
    }
    return (high << 8) | low;
}
