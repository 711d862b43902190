// SPDX-License-Identifier: MIT
// Timer 0 is the coarse clock (clock.c); its compare B makes the pixel clock beside that.
#include "hal/clock_out.h"

#include <avr/interrupt.h>
#include <avr/io.h>
#include <stdbool.h>
#include <util/atomic.h>

#include "avr/hal/board.h"  // BOARD_KEEP
#include "base/clock_out.h" // clock_out_*
#include "config.h"         // CONFIG_TIMER_HZ
#include "hal/clock.h"      // CLOCK_UNIT_TICKS

#if FEATURE_CLOCK_OUT

// A period of 0: there is no clock.
static struct clock_out own_clock;

// What of a port's registers pin CLOCK_OUT has.
#define WRITE_PORT(axis, port, bit)                                                      \
    if (high) {                                                                          \
        PORT##port |= (uint8_t)_BV(bit);                                                 \
    } else {                                                                             \
        PORT##port &= (uint8_t)~_BV(bit);                                                \
    }
#define WRITE_DDR(axis, port, bit)                                                       \
    if (output) {                                                                        \
        DDR##port |= (uint8_t)_BV(bit);                                                  \
    } else {                                                                             \
        DDR##port &= (uint8_t)~_BV(bit);                                                 \
    }
#define WANT_CLOCK_OUT BOARD_WANTED

static void make_pin_output(bool output)
{
#define BOARD_PIN(signal, axis, port, bit, header_pin)                                   \
    BOARD_KEEP(WANT_##signal)(WRITE_DDR(axis, port, bit))
#include BOARD_FILE
}

#if BOARD_CLOCK_OUT_IS_OC0B
// The hardware has made the level of this match, and needs to know that of the next one.
static inline void make_level(bool high)
{
    (void)high;
}

static inline void let_next_match_make(bool high)
{
    TCCR0A = (uint8_t)(_BV(COM0B1) | (high ? _BV(COM0B0) : 0));
}
#else
static inline void make_level(bool high)
{
#define BOARD_PIN(signal, axis, port, bit, header_pin)                                   \
    BOARD_KEEP(WANT_##signal)(WRITE_PORT(axis, port, bit))
#include BOARD_FILE
}

static inline void let_next_match_make(bool high)
{
    (void)high;
}
#endif
#undef WANT_CLOCK_OUT

static void clock_out_body(void) __asm__("__vector_clock_out_body")
    __attribute__((signal, used));

// Budget: 200 cycles, once a millisecond, or twice a period of a clock that is faster. The step
// interrupts are let in after 10 cycles.
ISR(TIMER0_COMPB_vect, ISR_NAKED)
{
    __asm__ volatile("sei\n\t"
                     "jmp __vector_clock_out_body");
}

__attribute__((always_inline)) static inline void let_match_come(void)
{
    OCR0B = (uint8_t)(OCR0B + clock_out_counts(&own_clock));
    let_next_match_make(clock_out_next_level(&own_clock));
}

// A match that comes before this is over waits: the clock is late then. The overflow's handler may
// interrupt this one, and this one that; each leaves the other's bit of TIMSK0 as it was.
static void clock_out_body(void)
{
    TIMSK0 &= (uint8_t)~_BV(OCIE0B);
    clock_out_match(&own_clock);
    make_level(own_clock.high);
    let_match_come();
    TIMSK0 |= (uint8_t)_BV(OCIE0B);
}

static void start(void)
{
    OCR0B = TCNT0;
    let_match_come();
    TIFR0 = (uint8_t)_BV(OCF0B);
    ATOMIC_BLOCK(ATOMIC_RESTORESTATE)
    {
        TIMSK0 |= (uint8_t)_BV(OCIE0B);
    }
}

static void stop(void)
{
    ATOMIC_BLOCK(ATOMIC_RESTORESTATE)
    {
        TIMSK0 &= (uint8_t)~_BV(OCIE0B);
    }
    TCCR0A = 0;
    make_level(false);
}

void clock_out_set(uint16_t hz)
{
    uint32_t period_counts =
        hz == 0 ? 0 : clock_out_period_counts(hz, CONFIG_TIMER_HZ / CLOCK_UNIT_TICKS);

    if (period_counts == own_clock.period_counts) {
        return;
    }
    stop();
    make_pin_output(hz != 0);
    clock_out_begin(&own_clock, period_counts);
    if (hz != 0) {
        start();
    }
}

#endif
