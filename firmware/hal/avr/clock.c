// SPDX-License-Identifier: MIT
// Timer 0 at clk/64: one count is 4 us, one overflow 1.024 ms.
#include "hal/clock.h"

#include <avr/interrupt.h>
#include <avr/io.h>
#include <util/atomic.h>

static volatile uint32_t overflows;

// Budget: 70 cycles, once a millisecond.
ISR(TIMER0_OVF_vect)
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

    ATOMIC_BLOCK(ATOMIC_RESTORESTATE)
    {
        high = overflows;
        low = TCNT0;
        // An overflow that is not served yet belongs to a count that has just wrapped.
        if ((TIFR0 & _BV(TOV0)) != 0 && low < 128u) {
            high++;
        }
    }
    return (high << 8) | low;
}
