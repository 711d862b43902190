// SPDX-License-Identifier: MIT
// Sections of known lengths, in turn: what the statistics say of them is reckoned anew in
// test_statistics.py, which has the same list. Every stay is so many nops and the OUT that ends it.
// Of the stays marked with a handler, one takes its 10 nops out of the main program's time.

#include <avr/interrupt.h>
#include <avr/io.h>

#include "result.h"

ISR(TIMER1_COMPB_vect, ISR_NAKED)
{
    __asm__ volatile(".rept 10\n\tnop\n\t.endr\n\treti\n\t");
}

#define STAY(section, nops)                                                              \
    __asm__ volatile("out %[gpior], %[value]\n\t"                                        \
                     ".rept " #nops "\n\tnop\n\t.endr\n\t"                               \
                     :                                                                   \
                     : [gpior] "I"(_SFR_IO_ADDR(GPIOR1)), [value] "r"(section))

int main(void)
{
    uint8_t s0 = 0, s1 = 1, s2 = 2, s3 = 3, s4 = 4, s5 = 5, s6 = 6;
    uint8_t back = 7, far = 9;

    // Kept in registers all the time: what loads one would lie in a stay.
    __asm__ volatile(""
                     : "+r"(s0),
                       "+r"(s1),
                       "+r"(s2),
                       "+r"(s3),
                       "+r"(s4),
                       "+r"(s5),
                       "+r"(s6),
                       "+r"(back),
                       "+r"(far));

    OCR1A = 0xFFFF;
    OCR1B = 600; // in one of the stays
    TIMSK1 = (uint8_t)(1U << OCIE1B);
    TCCR1B = (uint8_t)(1U << CS10);
    sei();
    STAY(s4, 100);
    STAY(s1, 30);
    STAY(back, 50);
    STAY(s5, 70);
    STAY(s2, 20);
    STAY(back, 10);
    STAY(s0, 40);
    STAY(s3, 15);
    STAY(s1, 25); // from one that is called to another
    STAY(back, 5);
    STAY(s4, 200);
    STAY(s5, 60);
    STAY(far, 33); // no such section: the last one
    STAY(s4, 90);
    STAY(s1, 31);
    STAY(back, 3);
    STAY(s1, 29);
    STAY(s0, 1); // not back to its caller
    STAY(s2, 12);
    STAY(back, 7);
    STAY(s4, 0);
    STAY(s6, 45);
    STAY(s1, 8);
    STAY(back, 4);
    STAY(s0, 0);
    cli();
    RESULT[0] = 0x600D;
    for (;;) {
    }
}
