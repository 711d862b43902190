// SPDX-License-Identifier: MIT
// The instruction that always runs behind RETI, where I was set already: an interrupt comes at
// every cycle around the RETI of a handler that lets others in. RESULT[n] for the n-th phase: bit 8
// when it came inside that handler, and in the low byte how many instructions of the main program
// ran between the two.

#include <avr/interrupt.h>
#include <avr/io.h>

#include "result.h"

#define PHASES 40U
#define FIRST  60U // the outer handler's match is at 40

// r25 counts the main program's instructions, r24 keeps the count at the outer handler, r23 and r22
// what the inner one sees: SPL and the count.
ISR(TIMER1_COMPB_vect, ISR_NAKED)
{
    __asm__ volatile("mov r24, r25\n\t"
                     "sei\n\t"
                     ".rept 20\n\tnop\n\t.endr\n\t"
                     "reti\n\t");
}

ISR(TIMER1_COMPA_vect, ISR_NAKED)
{
    __asm__ volatile("in r23, %[spl]\n\t"
                     "mov r22, r25\n\t"
                     "reti\n\t"
                     :
                     : [spl] "I"(_SFR_IO_ADDR(SPL)));
}

static __attribute__((noinline)) uint16_t phase(uint16_t match)
{
    uint8_t depth;
    uint8_t before;
    uint8_t after;
    uint8_t outside;

    TCCR1B = 0;
    TCNT1 = 0;
    OCR1A = match;
    OCR1B = 40;
    TIFR1 = 0xFF;
    TIMSK1 = (uint8_t)((1U << OCIE1A) | (1U << OCIE1B));
    __asm__ volatile("in %[outside], %[spl]\n\t"
                     "clr r25\n\t"
                     "sei\n\t"
                     "sts %[tccrb], %[on]\n\t"
                     ".rept 120\n\tinc r25\n\t.endr\n\t"
                     "cli\n\t"
                     "mov %[depth], r23\n\t"
                     "mov %[before], r24\n\t"
                     "mov %[after], r22\n\t"
                     : [depth] "=&r"(depth),
                       [before] "=&r"(before),
                       [after] "=&r"(after),
                       [outside] "=&r"(outside)
                     : [on] "r"((uint8_t)(1U << CS10)),
                       [tccrb] "n"(_SFR_MEM_ADDR(TCCR1B)),
                       [spl] "I"(_SFR_IO_ADDR(SPL))
                     : "r22", "r23", "r24", "r25");
    uint8_t pushed = (uint8_t)(outside - depth);

    return (uint16_t)((pushed > 3U ? 0x100U : 0U) | (uint8_t)(after - before));
}

int main(void)
{
    for (uint16_t i = 0; i < PHASES; i++) {
        RESULT[i] = phase((uint16_t)(FIRST + i));
    }
    RESULT[PHASES] = 0x600D;
    for (;;) {
    }
}
