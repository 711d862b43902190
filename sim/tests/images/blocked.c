// SPDX-License-Identifier: MIT
// A write to TCNT1 while the timer stands still blocks the match of the first clock, whenever that
// comes; a match behind it comes as ever. RESULT: 0 the flag OCF1B where TCNT1 is written to OCR1B,
// 1 where it is written to one below, 2 where it was OCR1B - 1, the timer counted one clock to
// OCR1B, and was not written, 3 the same with the write while held by TSM. 4, 5: a flag cleared in
// the step before it is set, and in that step. 6: 0x600D.

#include <avr/io.h>

#include "result.h"

#define MATCH 100U

static uint16_t clocks_from(uint16_t count, uint8_t holding)
{
    TCCR1B = 0;
    OCR1A = 0xFFFF;
    OCR1B = MATCH;
    if (holding) {
        GTCCR = (uint8_t)((1U << TSM) | (1U << PSRSYNC));
        TCCR1B = (uint8_t)(1U << CS10);
    }
    TCNT1 = count;
    TIFR1 = 0xFF;
    __asm__ volatile("sts %[tccrb], %[on]\n\t"
                     "out %[gtccr], __zero_reg__\n\t"
                     "nop\n\tnop\n\tnop\n\tnop\n\t"
                     "sts %[tccrb], __zero_reg__\n\t"
                     :
                     : [on] "r"((uint8_t)(1U << CS10)),
                       [tccrb] "n"(_SFR_MEM_ADDR(TCCR1B)),
                       [gtccr] "I"(_SFR_IO_ADDR(GTCCR)));
    return (uint16_t)(TIFR1 & (1U << OCF1B));
}

// Stops in the very clock before the match, and goes on without a write to TCNT1.
static uint16_t resumed(void)
{
    TCCR1B = 0;
    OCR1B = MATCH;
    TCNT1 = MATCH - 3U;
    TIFR1 = 0xFF;
    // sts to sts: two clocks are counted; TCNT1 stands at MATCH - 1 or MATCH.
    __asm__ volatile(
        "sts %[tccrb], %[on]\n\t"
        "sts %[tccrb], __zero_reg__\n\t"
        :
        : [on] "r"((uint8_t)(1U << CS10)), [tccrb] "n"(_SFR_MEM_ADDR(TCCR1B)));
    TIFR1 = 0xFF;
    __asm__ volatile(
        "sts %[tccrb], %[on]\n\t"
        "nop\n\tnop\n\t"
        "sts %[tccrb], __zero_reg__\n\t"
        :
        : [on] "r"((uint8_t)(1U << CS10)), [tccrb] "n"(_SFR_MEM_ADDR(TCCR1B)));
    return (uint16_t)(TIFR1 & (1U << OCF1B));
}

// TIFR1 written in the clock of this count: OCF1B is set one behind the match.
#define CLEARED_AT(clocks)                                                               \
    do {                                                                                 \
        TCCR1B = 0;                                                                      \
        OCR1B = MATCH;                                                                   \
        TCNT1 = 0;                                                                       \
        TIFR1 = 0xFF;                                                                    \
        __asm__ volatile("sts %[tccrb], %[on]\n\t"                                       \
                         ".rept " #clocks "\n\tnop\n\t.endr\n\t"                         \
                         "out %[tifr], %[flags]\n\t"                                     \
                         "nop\n\tnop\n\tnop\n\tnop\n\t"                                  \
                         "sts %[tccrb], __zero_reg__\n\t"                                \
                         :                                                               \
                         : [on] "r"((uint8_t)(1U << CS10)),                              \
                           [flags] "r"((uint8_t)0xFF),                                   \
                           [tccrb] "n"(_SFR_MEM_ADDR(TCCR1B)),                           \
                           [tifr] "I"(_SFR_IO_ADDR(TIFR1)));                             \
    } while (0)

int main(void)
{
    RESULT[0] = clocks_from(MATCH, 0);
    RESULT[1] = clocks_from(MATCH - 1U, 0);
    RESULT[2] = resumed();
    RESULT[3] = clocks_from(MATCH, 1);
    CLEARED_AT(100);
    RESULT[4] = TIFR1 & (1U << OCF1B);
    CLEARED_AT(101);
    RESULT[5] = TIFR1 & (1U << OCF1B);
    RESULT[6] = 0x600D;
    for (;;) {
    }
}
