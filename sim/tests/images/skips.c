// SPDX-License-Identifier: MIT
// Each skip instruction over each ADIW and SBIW: RESULT[0..] hold, for one case after the other, in
// the low byte how many of the two INC behind the skipped instruction ran (2), in the high byte the
// cycles from the skip instruction to the first INC (2: a skip over one word). Then 0x600D.

#include <avr/io.h>

#include "result.h"

#define CASE(skip, over)                                                                 \
    do {                                                                                 \
        uint8_t from;                                                                    \
        uint8_t to;                                                                      \
        uint8_t ran = 0;                                                                 \
        __asm__ volatile("lds %[from], %[now]\n\t" skip "\n\t" over "\n\t"               \
                         "inc %[ran]\n\t"                                                \
                         "inc %[ran]\n\t"                                                \
                         "lds %[to], %[now]\n\t"                                         \
                         : [from] "=&r"(from), [to] "=&r"(to), [ran] "+&r"(ran)          \
                         : [now] "n"(_SFR_MEM_ADDR(TCNT1)),                              \
                           [ones] "r"((uint8_t)0xFF),                                    \
                           [none] "r"((uint8_t)0),                                       \
                           [io] "I"(_SFR_IO_ADDR(GPIOR0))                                \
                         : "r26", "r27", "r30", "r31");                                  \
        uint8_t took = (uint8_t)(to - from);                                             \
        RESULT[at++] = (uint16_t)((uint16_t)(took - FRAME_CYCLES) << 8 | ran);           \
    } while (0)

// The rest of the first LDS behind its read, two INC, and the second LDS up to its read.
#define FRAME_CYCLES 4

#define EACH_SKIP(over)                                                                  \
    do {                                                                                 \
        GPIOR0 = 0x01;                                                                   \
        CASE("sbrs %[ones], 0", over);                                                   \
        CASE("sbrc %[none], 0", over);                                                   \
        CASE("sbis %[io], 0", over);                                                     \
        CASE("sbic %[io], 1", over);                                                     \
        CASE("cpse %[ones], %[ones]", over);                                             \
    } while (0)

int main(void)
{
    uint8_t at = 0;

    TCCR1B = (uint8_t)(1U << CS10);
    EACH_SKIP("adiw r30, 12");
    EACH_SKIP("adiw r26, 13");
    EACH_SKIP("adiw r30, 46");
    EACH_SKIP("sbiw r30, 31");
    EACH_SKIP("sbiw r26, 60");
    EACH_SKIP("sbiw r30, 14");
    EACH_SKIP("adiw r30, 11"); // these were right
    EACH_SKIP("sbiw r26, 0");
    RESULT[at] = 0x600D;
    for (;;) {
    }
}
