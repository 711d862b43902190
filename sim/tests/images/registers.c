// SPDX-License-Identifier: MIT
// What a program sees of a 16-bit timer, at known cycles. Each RESULT[] word is one experiment; the
// expected values and their reckoning are in test_timers.py, by the same numbers.
//
// Reckoning: `sts` takes two cycles and writes in its second (a); from a + 1 on the write is in
// force. A timer started by it has TCNT = 0 in cycle a + 1, which is the first cycle of the next
// instruction. `lds` also takes two and reads in its second, `in` takes one.

#include <avr/io.h>

#include "result.h"

#define NOPS(count) ".rept " #count "\n\tnop\n\t.endr\n\t"
#define STARTED     ((uint8_t)(1U << CS10))
#define STARTED_15  ((uint8_t)((1U << WGM13) | (1U << WGM12) | (1U << CS10)))
#define MODE_15_A   ((uint8_t)((1U << WGM11) | (1U << WGM10)))
#define REGISTERS                                                                        \
    [tccrb] "n"(_SFR_MEM_ADDR(TCCR1B)), [tcnt] "n"(_SFR_MEM_ADDR(TCNT1L)),               \
        [tcnth] "n"(_SFR_MEM_ADDR(TCNT1H)), [tifr] "I"(_SFR_IO_ADDR(TIFR1)),             \
        [ocral] "n"(_SFR_MEM_ADDR(OCR1AL)), [tov] "I"(TOV1), [ocfb] "I"(OCF1B)

static void stop(void)
{
    TCCR1B = 0;
    TCCR1A = 0;
    TCNT1 = 0;
    OCR1A = 0xFFFF;
    OCR1B = 0xFFFF;
    TIFR1 = 0xFF;
}

// 0, 1: TEMP is one for all registers, except that reading OCR1A leaves it alone.
static void temp(void)
{
    uint8_t low;
    uint8_t high;

    OCR1AH = 0x12;
    low = TCNT1L; // TCNT1 is 0: TEMP = 0
    OCR1AL = (uint8_t)(0x34U + low);
    RESULT[0] = OCR1A;
    OCR1BH = 0x56;
    low = OCR1AL;
    high = OCR1AH;
    OCR1BL = 0x78;
    RESULT[1] = OCR1B;
    (void)low;
    (void)high;
}

// 2, 3: the count, read at once and one nop later.
static void count(void)
{
    uint8_t low;

    stop();
    __asm__ volatile("sts %[tccrb], %[on]\n\t"
                     "lds %[low], %[tcnt]\n\t"
                     : [low] "=r"(low)
                     : [on] "r"(STARTED), REGISTERS);
    RESULT[2] = low;
    stop();
    __asm__ volatile("sts %[tccrb], %[on]\n\t" NOPS(1) "lds %[low], %[tcnt]\n\t"
                     : [low] "=r"(low)
                     : [on] "r"(STARTED), REGISTERS);
    RESULT[3] = low;
}

// 4, 5: mode 15, TOP = 99: TOV1 with TCNT = TOP still to go, and one cycle later.
static void overflow_flag(void)
{
    uint8_t flags;

    stop();
    OCR1A = 99;
    TCCR1A = MODE_15_A;
    __asm__ volatile("sts %[tccrb], %[on]\n\t" NOPS(99) "in %[flags], %[tifr]\n\t"
                     : [flags] "=r"(flags)
                     : [on] "r"(STARTED_15), REGISTERS);
    RESULT[4] = flags & (1U << TOV1);
    stop();
    OCR1A = 99;
    TCCR1A = MODE_15_A;
    __asm__ volatile("sts %[tccrb], %[on]\n\t" NOPS(100) "in %[flags], %[tifr]\n\t"
                     : [flags] "=r"(flags)
                     : [on] "r"(STARTED_15), REGISTERS);
    RESULT[5] = flags & (1U << TOV1);
}

// 21: the count read in the very cycle in which it goes from TOP to 0.
static void count_at_bottom(void)
{
    uint8_t low;

    stop();
    OCR1A = 99;
    TCCR1A = MODE_15_A;
    __asm__ volatile("sts %[tccrb], %[on]\n\t" NOPS(99) "lds %[low], %[tcnt]\n\t"
                     : [low] "=r"(low)
                     : [on] "r"(STARTED_15), REGISTERS);
    RESULT[21] = low;
}

// 6: in mode 15 the program reads the buffer. 7, 8: a buffer written in the last cycle but one of a
// period is loaded at its end (TCNT goes on to 150), one written in the last cycle is not.
static void buffer(void)
{
    uint8_t low;

    stop();
    OCR1A = 99;
    TCCR1A = MODE_15_A;
    TCCR1B = STARTED_15 & (uint8_t)~STARTED;
    OCR1A = 0x1234;
    RESULT[6] = OCR1A;

    stop();
    OCR1A = 99;
    OCR1AH = 0;
    TCCR1A = MODE_15_A;
    __asm__ volatile("sts %[tccrb], %[on]\n\t" NOPS(97) "sts %[ocral], %[top]\n\t" NOPS(
                         149) "lds %[low], %[tcnt]\n\t"
                     : [low] "=&r"(low)
                     : [on] "r"(STARTED_15), [top] "r"((uint8_t)199), REGISTERS);
    RESULT[7] = low;
    stop();
    OCR1A = 99;
    OCR1AH = 0;
    TCCR1A = MODE_15_A;
    __asm__ volatile("sts %[tccrb], %[on]\n\t" NOPS(98) "sts %[ocral], %[top]\n\t" NOPS(
                         149) "lds %[low], %[tcnt]\n\t"
                     : [low] "=&r"(low)
                     : [on] "r"(STARTED_15), [top] "r"((uint8_t)199), REGISTERS);
    RESULT[8] = low;
}

// 9: SBI on a flag register clears that flag alone. 10: a write of ones clears, of zeros does not.
static void clear_flags(void)
{
    stop();
    OCR1A = 99;
    OCR1B = 50;
    TCCR1A = MODE_15_A;
    TCCR1B = STARTED_15;
    __asm__ volatile(NOPS(200)::);
    TCCR1B = 0; // TOV1, OCF1A and OCF1B are set
    __asm__ volatile("sbi %[tifr], %[ocfb]\n\t" ::REGISTERS);
    RESULT[9] = TIFR1 & 0x7U;
    TIFR1 = (uint8_t)(1U << OCF1A);
    RESULT[10] = TIFR1 & 0x7U;
}

// 11, 12: OCR1B = 10, and TCNT1 written with 10 (the next clock's match is blocked) and with 9.
static void blocked_match(void)
{
    uint8_t flags;

    stop();
    OCR1B = 10;
    TCNT1H = 0;
    __asm__ volatile("sts %[tccrb], %[on]\n\t"
                     "sts %[tcnt], %[count]\n\t" NOPS(10) "in %[flags], %[tifr]\n\t"
                     : [flags] "=&r"(flags)
                     : [on] "r"(STARTED), [count] "r"((uint8_t)10), REGISTERS);
    RESULT[11] = flags & (1U << OCF1B);
    stop();
    OCR1B = 10;
    TCNT1H = 0;
    __asm__ volatile("sts %[tccrb], %[on]\n\t"
                     "sts %[tcnt], %[count]\n\t" NOPS(10) "in %[flags], %[tifr]\n\t"
                     : [flags] "=&r"(flags)
                     : [on] "r"(STARTED), [count] "r"((uint8_t)9), REGISTERS);
    RESULT[12] = flags & (1U << OCF1B);
}

// 13, 14: OCR1B = 20: OCF1B in the cycle of TCNT = 20 (not yet) and of 21. 15: OCR1B above TOP.
static void match_flag(void)
{
    uint8_t flags;

    stop();
    OCR1B = 20;
    __asm__ volatile("sts %[tccrb], %[on]\n\t" NOPS(20) "in %[flags], %[tifr]\n\t"
                     : [flags] "=r"(flags)
                     : [on] "r"(STARTED), REGISTERS);
    RESULT[13] = flags & (1U << OCF1B);
    stop();
    OCR1B = 20;
    __asm__ volatile("sts %[tccrb], %[on]\n\t" NOPS(21) "in %[flags], %[tifr]\n\t"
                     : [flags] "=r"(flags)
                     : [on] "r"(STARTED), REGISTERS);
    RESULT[14] = flags & (1U << OCF1B);
    stop();
    OCR1A = 99;
    OCR1B = 100;
    TCCR1A = MODE_15_A;
    TCCR1B = STARTED_15;
    __asm__ volatile(NOPS(300)::);
    RESULT[15] = TIFR1 & (1U << OCF1B);
}

// 16: the count stands while the clock is off, and goes on from there.
static void stop_and_go(void)
{
    uint8_t low;

    stop();
    __asm__ volatile(
        "sts %[tccrb], %[on]\n\t" NOPS(48) "sts %[tccrb], __zero_reg__\n\t" NOPS(
            500) "sts %[tccrb], %[on]\n\t" NOPS(9) "lds %[low], %[tcnt]\n\t"
        : [low] "=r"(low)
        : [on] "r"(STARTED), REGISTERS);
    RESULT[16] = low;
}

// 18 to 20: normal mode counts on from 0xFFFF to 0: the count behind that, TOV1 in the cycle of
// 0xFFFF and of 0.
static void wrap(void)
{
    uint8_t low;
    uint8_t flags;

    stop();
    TCNT1 = 0xFFF0;
    __asm__ volatile("sts %[tccrb], %[on]\n\t" NOPS(20) "lds %[low], %[tcnt]\n\t"
                     : [low] "=r"(low)
                     : [on] "r"(STARTED), REGISTERS);
    RESULT[18] = low;
    stop();
    TCNT1 = 0xFFF0;
    TIFR1 = 0xFF;
    __asm__ volatile("sts %[tccrb], %[on]\n\t" NOPS(15) "in %[flags], %[tifr]\n\t"
                     : [flags] "=r"(flags)
                     : [on] "r"(STARTED), REGISTERS);
    RESULT[19] = flags & (1U << TOV1);
    stop();
    TCNT1 = 0xFFF0;
    TIFR1 = 0xFF;
    __asm__ volatile("sts %[tccrb], %[on]\n\t" NOPS(16) "in %[flags], %[tifr]\n\t"
                     : [flags] "=r"(flags)
                     : [on] "r"(STARTED), REGISTERS);
    RESULT[20] = flags & (1U << TOV1);
}

int main(void)
{
    stop();
    temp();
    count();
    overflow_flag();
    count_at_bottom();
    buffer();
    clear_flags();
    blocked_match();
    match_flag();
    stop_and_go();
    wrap();
    RESULT[17] = 0x600D;
    for (;;) {
    }
}
