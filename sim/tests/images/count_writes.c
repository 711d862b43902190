// SPDX-License-Identifier: MIT
// TCNT1 written while it counts, in both halves, and read back so many nops later. RESULT: 0..3 the
// count behind 0 to 3 nops, 4 across an overflow, 5 with a low byte that wraps, 6 0x600D.

#include <avr/io.h>

#include "result.h"

#define COUNT_BEHIND(result, count, nops)                                                \
    do {                                                                                 \
        uint8_t low;                                                                     \
        uint8_t high;                                                                    \
        __asm__ volatile("sts %[tcnth], %[to_high]\n\t"                                  \
                         "sts %[tcntl], %[to_low]\n\t"                                   \
                         ".rept " #nops "\n\tnop\n\t.endr\n\t"                           \
                         "lds %[low], %[tcntl]\n\t"                                      \
                         "lds %[high], %[tcnth]\n\t"                                     \
                         : [low] "=&r"(low), [high] "=&r"(high)                          \
                         : [to_low] "r"((uint8_t)(count)),                               \
                           [to_high] "r"((uint8_t)((count) >> 8)),                       \
                           [tcntl] "n"(_SFR_MEM_ADDR(TCNT1L)),                           \
                           [tcnth] "n"(_SFR_MEM_ADDR(TCNT1H)));                          \
        RESULT[result] = (uint16_t)(high << 8 | low);                                    \
    } while (0)

int main(void)
{
    TCCR1B = (uint8_t)(1U << CS10);
    COUNT_BEHIND(0, 0x1234U, 0);
    COUNT_BEHIND(1, 0x1234U, 1);
    COUNT_BEHIND(2, 0x1234U, 2);
    COUNT_BEHIND(3, 0x1234U, 3);
    COUNT_BEHIND(4, 0xFFFEU, 10);
    COUNT_BEHIND(5, 0x12FEU, 10);
    RESULT[6] = 0x600D;
    for (;;) {
    }
}
