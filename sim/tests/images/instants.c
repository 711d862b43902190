// SPDX-License-Identifier: MIT
// In which cycle timer 1 does what it is told; GPIOR2 says what is tried (the test pokes it), and
// test_timers.py reckons. STEP is OC1B.
//
// As in registers.c: a timer that `sts` starts has TCNT = 0 in the first cycle of the next
// instruction, and the write of `sts` is in force behind its second cycle.

#include <avr/interrupt.h>
#include <avr/io.h>

#include "result.h"

#if defined(__AVR_ATmega2560__)
#define STEP_BIT 6
#elif defined(__AVR_ATmega1284P__)
#define STEP_BIT 4 // of port D
#else
#define STEP_BIT 2
#endif
#if defined(__AVR_ATmega1284P__)
#define STEP_PORT PORTD
#define STEP_DDR  DDRD
#else
#define STEP_PORT PORTB
#define STEP_DDR  DDRB
#endif

enum {
    CONNECT_IN_TIME,
    CONNECT_LATE,
    DISCONNECT,
    READ_CAPTURE,
    TSM_ALONE,
    COMPARE,
    CLEARED,
    CANCELER
};

// Each with a frame of its own: branches do not reach over so many nops.
#define APART __attribute__((noinline))

#define NOPS(count)  ".rept " #count "\n\tnop\n\t.endr\n\t"
#define RUNNING      ((uint8_t)((1U << WGM13) | (1U << WGM12) | (1U << CS10)))
#define UNCONNECTED  ((uint8_t)((1U << WGM11) | (1U << WGM10)))
#define CONNECTED    ((uint8_t)(UNCONNECTED | (1U << COM1B1) | (1U << COM1B0)))
#define PERIOD_TICKS 1000U
#define MATCH        50U

static void set_up(uint8_t control)
{
    STEP_DDR = (uint8_t)(1U << STEP_BIT);
    OCR1A = PERIOD_TICKS - 1U;
    OCR1B = MATCH;
    TCCR1A = control;
}

// A pulse of the port at STEP, if STEP is the port's; start the timer, and write another TCCR1A so
// many nops later.
#define CHANGE(nops, from, to)                                                           \
    do {                                                                                 \
        set_up(from);                                                                    \
        __asm__ volatile(                                                                \
            "sbi %[port], %[bit]\n\t"                                                    \
            "cbi %[port], %[bit]\n\t"                                                    \
            "sts %[tccrb], %[on]\n\t" NOPS(nops) "sts %[tccra], %[then]\n\t"             \
            :                                                                            \
            : [port] "I"(_SFR_IO_ADDR(STEP_PORT)),                                       \
              [bit] "I"(STEP_BIT),                                                       \
              [on] "r"(RUNNING),                                                         \
              [then] "r"(to),                                                            \
              [tccra] "n"(_SFR_MEM_ADDR(TCCR1A)),                                        \
              [tccrb] "n"(_SFR_MEM_ADDR(TCCR1B)));                                       \
    } while (0)

APART static void connect_in_time(void)
{
    CHANGE(48, UNCONNECTED, CONNECTED);
}

APART static void connect_late(void)
{
    CHANGE(49, UNCONNECTED, CONNECTED);
}

APART static void disconnect(void)
{
    CHANGE(58, CONNECTED, UNCONNECTED);
}

// STEP rises, and 40 cycles later ICR1 is read.
APART static void read_capture(void)
{
    uint8_t low;

    STEP_DDR = (uint8_t)(1U << STEP_BIT);
    TCCR1B = (uint8_t)((1U << ICES1) | (1U << CS10));
    __asm__ volatile(NOPS(200) "sbi %[port], %[bit]\n\t" NOPS(39) "lds %[low], %[icr]\n\t"
                     : [low] "=r"(low)
                     : [port] "I"(_SFR_IO_ADDR(STEP_PORT)),
                       [bit] "I"(STEP_BIT),
                       [icr] "n"(_SFR_MEM_ADDR(ICR1L)));
    RESULT[0] = low;
    RESULT[1] = 0x600D;
}

// TCNT1 two nops apart, the first of them behind a write of TSM without PSRSYNC.
APART static void hold_by_half(void)
{
    TCCR1B = (uint8_t)(1U << CS10);
    GTCCR = (uint8_t)(1U << TSM);
    RESULT[0] = TCNT1L;
    __asm__ volatile("nop\n\tnop\n\t");
    RESULT[0] = (uint16_t)(TCNT1L != RESULT[0]);
    GTCCR = 0;
}

ISR(TIMER1_COMPB_vect, ISR_NAKED)
{
    __asm__ volatile("lds r24, %[tcnt]\n\t"
                     "sts %[result], r24\n\t"
                     "reti\n\t"
                     :
                     : [tcnt] "n"(_SFR_MEM_ADDR(TCNT1L)), [result] "n"(RESULT_ADDRESS));
}

// A compare value that is written while the timer counts to it interrupts as one of before does.
APART static void write_compare(void)
{
    OCR1B = 0xFFFF;
    OCR1BH = 0;
    TIMSK1 = (uint8_t)(1U << OCIE1B);
    sei();
    __asm__ volatile("sts %[tccrb], %[on]\n\t"
                     "sts %[ocrbl], %[match]\n\t" NOPS(100)
                     :
                     : [on] "r"((uint8_t)(1U << CS10)),
                       [match] "r"((uint8_t)MATCH),
                       [ocrbl] "n"(_SFR_MEM_ADDR(OCR1BL)),
                       [tccrb] "n"(_SFR_MEM_ADDR(TCCR1B))
                     : "r24");
    RESULT[1] = 0x600D;
}

// A flag that the program clears before it lets interrupts in interrupts no more.
APART static void clear_in_time(void)
{
    OCR1B = MATCH;
    TIMSK1 = (uint8_t)(1U << OCIE1B);
    TCCR1B = (uint8_t)(1U << CS10);
    __asm__ volatile(NOPS(100)::);
    RESULT[1] = TIFR1 & (1U << OCF1B);
    TIFR1 = (uint8_t)(1U << OCF1B);
    sei();
    __asm__ volatile("nop\n\tnop\n\t" ::: "r24");
}

APART static void count_captures(void)
{
    TCCR1B = (uint8_t)((1U << ICNC1) | (1U << ICES1) | (1U << CS10));
    for (;;) {
        if ((TIFR1 & (1U << ICF1)) != 0) {
            TIFR1 = (uint8_t)(1U << ICF1);
            RESULT[0] = RESULT[0] + 1U;
        }
    }
}

int main(void)
{
    RESULT[0] = RESULT[1] = 0;
    switch (GPIOR2) {
    case CONNECT_IN_TIME:
        connect_in_time();
        break;
    case CONNECT_LATE:
        connect_late();
        break;
    case DISCONNECT:
        disconnect();
        break;
    case READ_CAPTURE:
        read_capture();
        break;
    case TSM_ALONE:
        hold_by_half();
        break;
    case COMPARE:
        write_compare();
        break;
    case CLEARED:
        clear_in_time();
        break;
    default:
        count_captures();
        break;
    }
    for (;;) {
    }
}
