// SPDX-License-Identifier: MIT
// The third compare channel of timer 1 in mode 15, TOP = 99: flag and buffer. Only the Mega has
// one. Each RESULT[] word is OCF1C at a known count; test_timers.py has the reckoning.

#include <avr/io.h>

#include "result.h"

#if defined(OCR1C)
#define NOPS(count) ".rept " #count "\n\tnop\n\t.endr\n\t"
#define STARTED_15  ((uint8_t)((1U << WGM13) | (1U << WGM12) | (1U << CS10)))
#define MODE_15_A   ((uint8_t)((1U << WGM11) | (1U << WGM10)))

static void stop(uint8_t compare)
{
    TCCR1B = 0;
    TCCR1A = 0; // mode 0: what is written next counts at once
    TCNT1 = 0;
    OCR1A = 99;
    OCR1C = compare;
    TIFR1 = 0xFF;
    TCCR1A = MODE_15_A;
    OCR1CH = 0; // in TEMP
}

// Starts the timer, writes 30 to OCR1C at count 10 and 11 and reads the flag at count `after` + 12;
// `middle` stands before the read.
#define EXPERIMENT(at, compare, after, middle)                                           \
    do {                                                                                 \
        uint8_t flags;                                                                   \
                                                                                         \
        stop(compare);                                                                   \
        __asm__ volatile(                                                                \
            "sts %[tccrb], %[on]\n\t" NOPS(10) "sts %[ocrcl], %[new]\n\t" NOPS(after)    \
                middle "in %[flags], %[tifr]\n\t"                                        \
            : [flags] "=&r"(flags)                                                       \
            : [on] "r"(STARTED_15),                                                      \
              [new] "r"((uint8_t)30),                                                    \
              [tccrb] "n"(_SFR_MEM_ADDR(TCCR1B)),                                        \
              [ocrcl] "n"(_SFR_MEM_ADDR(OCR1CL)),                                        \
              [tifr] "I"(_SFR_IO_ADDR(TIFR1)),                                           \
              [ocfc] "I"(OCF1C));                                                        \
        RESULT[at] = flags & (1U << OCF1C);                                              \
    } while (0)

static void experiments(void)
{
    EXPERIMENT(0, 20, 8, "");
    EXPERIMENT(1, 20, 9, "");
    EXPERIMENT(2, 90, 48, "");
    EXPERIMENT(3, 90, 80, "");
    EXPERIMENT(4, 90, 81, "sbi %[tifr], %[ocfc]\n\t" NOPS(35));
    EXPERIMENT(5, 90, 81, "sbi %[tifr], %[ocfc]\n\t" NOPS(36));
    stop(90);
    OCR1C = 0x1234;
    RESULT[6] = OCR1C; // the program reads the buffer
}
#else
static void experiments(void)
{
}
#endif

int main(void)
{
    experiments();
    RESULT[7] = 0x600D;
    for (;;) {
    }
}
