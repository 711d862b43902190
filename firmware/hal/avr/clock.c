// SPDX-License-Identifier: MIT
// The coarse clock is timer 0 at clk/64: one count is a unit, and the timer overflows every 256
// units (1.024 ms at 16 MHz).
#include "hal/clock.h"

#include <avr/interrupt.h>
#include <avr/io.h>
#include <stdbool.h>

#include "config.h" // CONFIG_AXES

#if CONFIG_AXES == 1
static volatile uint32_t clock_overflows;

// Budget: 70 cycles, once a millisecond. The step interrupts are let in at once.
ISR(TIMER0_OVF_vect, ISR_NOBLOCK)
{
    clock_overflows++;
}
#else
#include "hal/avr/clock_units.h" // clock_overflows

volatile uint32_t clock_overflows;

// Budget: 40 cycles, once a millisecond. The step interrupts are let in after 21 cycles, once in
// 262 ms after 28. So the overflow is counted before anything else can come: under traffic that
// leaves a handler an instruction now and then, the next overflow or even a third one would come
// before it was counted, and a capture may ask for the time. It asks for the low 16 bits.
ISR(TIMER0_OVF_vect, ISR_NAKED)
{
    __asm__ volatile("push r24\n\t"
                     "in r24, __SREG__\n\t"
                     "push r24\n\t"
                     "lds r24, %[overflows]\n\t"
                     "inc r24\n\t"
                     "sts %[overflows], r24\n\t"
                     "breq 2f\n"
                     "1: sei\n\t"
                     "pop r24\n\t"
                     "out __SREG__, r24\n\t"
                     "pop r24\n\t"
                     "reti\n"
                     "2: lds r24, %[overflows] + 1\n\t"
                     "inc r24\n\t"
                     "sts %[overflows] + 1, r24\n\t"
                     "brne 1b\n\t"
                     "sei\n\t"
                     "lds r24, %[overflows] + 2\n\t"
                     "inc r24\n\t"
                     "sts %[overflows] + 2, r24\n\t"
                     "brne 1b\n\t"
                     "lds r24, %[overflows] + 3\n\t"
                     "inc r24\n\t"
                     "sts %[overflows] + 3, r24\n\t"
                     "rjmp 1b"
                     :
                     : [overflows] "i"(&clock_overflows));
}
#endif

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
        high = clock_overflows;
        low = TCNT0;
        pending = (TIFR0 & _BV(TOV0)) != 0;
    } while (high != clock_overflows);
    // A large count was read before the wrap: the flag was then set between the two reads.
    if (pending && low < 128u) {
        high++;
    }
    return (high << 8) | low;
}
