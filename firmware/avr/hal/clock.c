// SPDX-License-Identifier: MIT
// The coarse clock is timer 0 at clk/64: one count is a unit, and the timer overflows every 256
// units (1.024 ms at 16 MHz).
#include "hal/clock.h"

#include <avr/interrupt.h>
#include <avr/io.h>
#include <stdbool.h>

#include "avr/hal/clock_units.h" // clock_overflows
#include "config.h"              // CONFIG_AXES

// The overflow interrupt beside compare B's (clock_out.c), which only the main loop switches.
#define OVERFLOW_TOO ((uint8_t)((FEATURE_CLOCK_OUT ? TIMSK0 : 0) | _BV(TOIE0)))

#if CONFIG_AXES == 1
volatile uint32_t clock_overflows;

// Budget: 50 cycles, once a millisecond; 35 where one byte is enough. The step interrupts are let
// in at once. A byte is counted up when the one below it has wrapped. Nobody asks for the fourth:
// clock_now_units() has no room for it.
ISR(TIMER0_OVF_vect, ISR_NAKED)
{
    __asm__ volatile("sei\n\t"
                     "push r24\n\t"
                     "in r24, __SREG__\n\t"
                     "push r24\n\t"
                     ".irp byte, 0, 1, 2\n\t"
                     "lds r24, %[count] + \\byte\n\t"
                     "inc r24\n\t"
                     "sts %[count] + \\byte, r24\n\t"
                     "brne 1f\n\t"
                     ".endr\n"
                     "1: pop r24\n\t"
                     "out __SREG__, r24\n\t"
                     "pop r24\n\t"
                     "reti"
                     :
                     : [count] "i"(&clock_overflows));
}
#else
#include <util/atomic.h>

#include "avr/hal/flag_bits.h" // FLAG_CLOCK_COUNTING

volatile uint32_t clock_overflows;

static void clock_body(void) __asm__("__vector_clock_body") __attribute__((signal, used));

// Budget: 100 cycles, once a millisecond. The step interrupts are let in after 10 cycles. A capture
// may ask for the time in the middle of this handler: until the overflow is counted, a bit stands
// in for the flag that the hardware has cleared. SEI lets SBI execute before any interrupt.
ISR(TIMER0_OVF_vect, ISR_NAKED)
{
    __asm__ volatile(
        "sei\n\t"
        "sbi %[flags], %[counting]\n\t"
        "jmp __vector_clock_body"
        :
        : [flags] "I"(_SFR_IO_ADDR(GPIOR0)), [counting] "I"(FLAG_CLOCK_COUNTING));
}

// Under traffic that leaves this handler an instruction now and then, the next overflow may come
// before this one is counted. Its handler waits meanwhile, or one of the two would be lost.
static void clock_body(void)
{
    TIMSK0 = FEATURE_CLOCK_OUT ? TIMSK0 & (uint8_t)~_BV(TOIE0) : 0;
    uint32_t overflows = clock_overflows + 1u;

    ATOMIC_BLOCK(ATOMIC_FORCEON)
    {
        clock_overflows = overflows;
        GPIOR0 &= (uint8_t)~_BV(FLAG_CLOCK_COUNTING);
    }
    TIMSK0 = OVERFLOW_TOO;
}
#endif

void clock_start(void)
{
    TCCR0B = (uint8_t)(_BV(CS01) | _BV(CS00));
    TIMSK0 = OVERFLOW_TOO;
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
    } while ((uint8_t)high != *(const volatile uint8_t *)&clock_overflows);
    // A large count was read before the wrap: the flag was then set between the two reads.
    if (pending && low < 128u) {
        high++;
    }
    return (high << 8) | low;
}
