// SPDX-License-Identifier: MIT
// The watchdog, case by case (the test pokes it into the RAM at CASE, which outlasts the resets).
// RESULT[0] counts the starts, RESULT[n] is MCUSR at the nth, RESULT[16 + n] WDTCSR. Each watchdog
// interrupt turns PERMIT over. Expected values in test_watchdog.py.

#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/wdt.h>

#include "result.h"

#define CASE (*(volatile uint8_t *)0x5F0)

#if defined(__AVR_ATmega2560__)
#define PERMIT_DDR  DDRE
#define PERMIT_PIN  PINE
#define PERMIT_MASK (1U << 3)
#else
#define PERMIT_DDR  DDRD
#define PERMIT_PIN  PIND
#define PERMIT_MASK (1U << 6)
#endif

#define SEQUENCE ((uint8_t)((1U << WDCE) | (1U << WDE)))

// What it interrupts keeps nothing in r24. A one turns the output over.
ISR(WDT_vect, ISR_NAKED)
{
    __asm__ volatile("ldi r24, %[mask]\n\t"
                     "out %[pin], r24\n\t"
                     "reti\n\t"
                     :
                     : [mask] "M"(PERMIT_MASK), [pin] "I"(_SFR_IO_ADDR(PERMIT_PIN)));
}

// Writes `value` so many nops after the sequence's first write: with two, in its fourth cycle.
#define CHANGE(nops, value)                                                              \
    __asm__ volatile("sts %[at], %[open]\n\t"                                            \
                     ".rept " #nops "\n\tnop\n\t.endr\n\t"                               \
                     "sts %[at], %[to]\n\t" ::[at] "n"(_SFR_MEM_ADDR(WDTCSR)),           \
                     [open] "r"(SEQUENCE),                                               \
                     [to] "r"((uint8_t)(value)))

// WDCE as it is read so many nops after the sequence's first write.
#define LOOK(at, nops)                                                                   \
    do {                                                                                 \
        uint8_t seen;                                                                    \
                                                                                         \
        __asm__ volatile("sts %[at_], %[open]\n\t"                                       \
                         ".rept " #nops "\n\tnop\n\t.endr\n\t"                           \
                         "lds %[seen], %[at_]\n\t"                                       \
                         : [seen] "=&r"(seen)                                            \
                         : [at_] "n"(_SFR_MEM_ADDR(WDTCSR)), [open] "r"(SEQUENCE));      \
        RESULT[at] = seen & (1U << WDCE);                                                \
    } while (0)

static void mark(void)
{
    PERMIT_PIN = (uint8_t)PERMIT_MASK;
}

// Fed every 15 ms, five times.
static void fed(void)
{
    CHANGE(0, 1U << WDE); // 16 ms
    for (uint8_t i = 0; i < 5; i++) {
        __builtin_avr_delay_cycles(240000);
        wdt_reset();
    }
    mark();
}

static void prescalers(uint8_t wdp)
{
    CHANGE(0, (1U << WDE) | (wdp & 7U) | ((wdp & 8U) << 2));
    mark();
}

// The prescaler is changed after 100 ms from 2 s to 64 ms: the count has passed that.
static void shortened(void)
{
    CHANGE(0, (1U << WDE) | 7U);
    __builtin_avr_delay_cycles(1600000);
    mark();
    CHANGE(0, (1U << WDE) | 2U);
}

// Interrupts only, each out of a sleep: one comes as late as the other.
__attribute__((noreturn)) static void sleep_between(void)
{
    SMCR = (uint8_t)(1U << SE); // idle
    sei();
    mark();
    CHANGE(0, 1U << WDIE);
    for (;;) {
        __asm__ volatile("sleep");
    }
}

// Interrupts only, each out of a loop of three cycles: how late one is answered changes.
__attribute__((noreturn)) static void turn_between(void)
{
    sei();
    mark();
    CHANGE(0, 1U << WDIE);
    __asm__ volatile("1:\n\tnop\n\trjmp 1b");
    __builtin_unreachable();
}

// WDR, then the reset out of a sleep.
static void sleep_to_the_end(void)
{
    SMCR = (uint8_t)(1U << SE);
    CHANGE(0, 1U << WDE);
    __builtin_avr_delay_cycles(1000);
    sei();
    mark();
    __asm__ volatile("wdr\n\tsleep");
}

static void interrupt_and_reset(void)
{
    CHANGE(0, (1U << WDIE) | (1U << WDE));
    mark();
}

// WDIF waits; cleared by a one, not by a zero.
static void flag_waits(void)
{
    CHANGE(0, 1U << WDIE);
    __builtin_avr_delay_cycles(300000);
    WDTCSR = (uint8_t)(1U << WDIE);
    RESULT[30] = WDTCSR;
    WDTCSR = (uint8_t)((1U << WDIF) | (1U << WDIE));
    RESULT[31] = WDTCSR;
    LOOK(32, 2);
    LOOK(33, 3);
}

static void run_other(uint8_t what)
{
    if (what == 10) {
        sleep_between();
    } else if (what == 11) {
        sleep_to_the_end();
    } else if (what == 12) {
        turn_between();
    } else { // 20 + WDP
        prescalers((uint8_t)(what - 20U));
    }
}

static void run(uint8_t what)
{
    switch (what) {
    case 1: // in the sequence's fourth cycle: 32 ms; and WDE cannot be cleared without it
        CHANGE(2, (1U << WDE) | 1U);
        WDTCSR = 0;
        RESULT[30] = WDTCSR;
        mark();
        break;
    case 2: // in its fifth: still 16 ms
        CHANGE(3, (1U << WDE) | 1U);
        mark();
        break;
    case 3: // interrupts only
        CHANGE(0, 1U << WDIE);
        mark();
        sei();
        break;
    case 4: // one interrupt, then the reset
        interrupt_and_reset();
        sei();
        break;
    case 5: // the interrupt is not served: the reset all the same
        interrupt_and_reset();
        break;
    case 6:
        fed();
        break;
    case 7:
        shortened();
        break;
    case 8:
        flag_waits();
        break;
    case 9: // reserved
        CHANGE(0, (1U << WDE) | (1U << WDP3) | 2U);
        break;
    default:
        run_other(what);
        break;
    }
}

int main(void)
{
    uint16_t starts = ++RESULT[0];

    RESULT[starts] = MCUSR;
    RESULT[16 + starts] = WDTCSR;
    PERMIT_DDR = (uint8_t)PERMIT_MASK;
    if (starts == 2) { // WDRF still set: it cannot be turned off, and resets again
        CHANGE(0, 0);
        MCUSR = 0xFF; // sets nothing
    } else if (starts > 2) {
        MCUSR = 0;
        CHANGE(0, 0);
        RESULT[29] = WDTCSR;
    } else {
        MCUSR = 0;
        run(CASE);
    }
    for (;;) {
    }
}
