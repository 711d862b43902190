// SPDX-License-Identifier: MIT
// Timer 0 is the coarse clock (clock.c); its compare B makes the pixel clock beside that.
#include "hal/clock_out.h"

#include <avr/interrupt.h>
#include <avr/io.h>
#include <stdbool.h>
#include <util/atomic.h>

#include "avr/hal/board.h"       // BOARD_KEEP
#include "avr/hal/clock_units.h" // clock_interrupts
#include "clock/clock_out.h"     // clock_out_begin, clock_out_match
#include "config.h"              // CONFIG_TIMER_HZ
#include "hal/clock.h"           // CLOCK_UNIT_TICKS

#if FEATURE_CLOCK_OUT

static uint16_t set_hz; // the clock that there is
static struct clock_out own_clock;
static volatile bool serving;

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

// Budget: 140 cycles, once a millisecond and once an edge. The step interrupts are let in after 10
// cycles.
ISR(TIMER0_COMPB_vect, ISR_NAKED)
{
    __asm__ volatile("sei\n\t"
                     "jmp __vector_clock_out_body");
}

// Under traffic that leaves this handler an instruction now and then, the next match may come before
// this one is over: that match is left out, the clock is late.
static void clock_out_body(void)
{
    if (serving) {
        return;
    }
    serving = true;
    make_level(clock_out_next_level(&own_clock));
    OCR0B = (uint8_t)(OCR0B + clock_out_match(&own_clock));
    let_next_match_make(clock_out_next_level(&own_clock));
    serving = false;
}

static void start(uint16_t hz)
{
    clock_out_begin(&own_clock, hz, CONFIG_TIMER_HZ / CLOCK_UNIT_TICKS);
    let_next_match_make(false);
    OCR0B = (uint8_t)(TCNT0 + CLOCK_OUT_COUNTS_MAX / 2u);
    TIFR0 = (uint8_t)_BV(OCF0B);
    clock_interrupts |= (uint8_t)_BV(OCIE0B);
    TIMSK0 = clock_interrupts;
}

static void stop(void)
{
    clock_interrupts &= (uint8_t)~_BV(OCIE0B);
    TIMSK0 = clock_interrupts;
    TCCR0A = 0;
    make_level(false);
}

void clock_out_set(uint16_t hz)
{
    if (hz == set_hz) {
        return;
    }
    set_hz = hz;
    ATOMIC_BLOCK(ATOMIC_RESTORESTATE)
    {
        stop();
        make_pin_output(hz != 0);
    }
    // Nobody but the interrupt, which is off, knows the clock.
    if (hz != 0) {
        start(hz);
    }
}

#endif
