// SPDX-License-Identifier: MIT
// Timer 0 at clk/64: one count is a unit, one overflow 256 of them (1.024 ms at 16 MHz).
#include "hal/clock.h"

#include <avr/interrupt.h>
#include <avr/io.h>
#include <stdbool.h>

static volatile uint32_t timer0_overflows;

// Budget: 70 cycles, once a millisecond, the step interrupts let in at once.
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

// An overflow may wait behind step interrupts while the count has long wrapped: it is looked for.
// One that was served in between is a reason to look again, not one to hold interrupts off.
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
    // The flag may have appeared behind a count that had not wrapped yet.
    if (pending && low < 128u) {
        high++;
    }
    return (high << 8) | low;
}
