// SPDX-License-Identifier: MIT
// Timer 0 at clk/64: one count is 4 us, one overflow 1.024 ms.
#include "hal/clock.h"

#include <avr/interrupt.h>
#include <avr/io.h>

static volatile uint32_t overflows;

// Budget: 70 cycles, once a millisecond, the step interrupts let in at once.
ISR(TIMER0_OVF_vect, ISR_NOBLOCK)
{
    overflows++;
}

void clock_start(void)
{
    TCCR0A = 0;
    TCCR0B = (uint8_t)(_BV(CS01) | _BV(CS00));
    TIMSK0 = (uint8_t)_BV(TOIE0);
}

uint32_t clock_now_4us(void)
{
    uint32_t high = 0;
    uint8_t low = 0;

    // Again when an overflow came in between: no reason to hold interrupts off.
    do {
        high = overflows;
        low = TCNT0;
    } while (high != overflows);
    return (high << 8) | low;
}
