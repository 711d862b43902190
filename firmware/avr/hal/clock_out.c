// SPDX-License-Identifier: MIT
// Timer 2 in CTC mode: the count returns to 0 after OCR2A, which is a match of both channels. The
// board file says which of the two has its output on pin CLOCK_OUT.
#include "hal/clock_out.h"

#include <avr/io.h>
#include <stdbool.h>

#include "avr/hal/board.h"        // BOARD_KEEP
#include "clock/clock_out_plan.h" // clock_out_plan_of
#include "config.h"               // CONFIG_TIMER_HZ

#if FEATURE_CLOCK_OUT

#define JOIN(a, b, c)      JOIN_NOW(a, b, c)
#define JOIN_NOW(a, b, c)  a##b##c
#define OUTPUT_TOGGLE_BITS ((uint8_t)_BV(JOIN(COM2, BOARD_CLOCK_OUT_CHANNEL, 0)))
#define OUTPUT_LOW_BITS    ((uint8_t)_BV(JOIN(COM2, BOARD_CLOCK_OUT_CHANNEL, 1)))
#define OUTPUT_HIGH_BITS   ((uint8_t)(OUTPUT_TOGGLE_BITS | OUTPUT_LOW_BITS))
#define MATCH_FLAG         ((uint8_t)_BV(JOIN(OCF2, BOARD_CLOCK_OUT_CHANNEL, )))

static uint16_t set_hz; // the clock that there is
static struct {
    uint8_t matches; // in half a period; 1: the hardware needs no help
    uint8_t left;    // of them until the level changes
    bool high;       // what the next match makes the output
} slow;

#define WRITE_DDR(axis, port, bit)                                                       \
    if (output) {                                                                        \
        DDR##port |= (uint8_t)_BV(bit);                                                  \
    } else {                                                                             \
        DDR##port &= (uint8_t)~_BV(bit);                                                 \
    }
static void make_pin_output(bool output)
{
#define WANT_CLOCK_OUT BOARD_WANTED
#define BOARD_PIN(signal, axis, port, bit, header_pin)                                   \
    BOARD_KEEP(WANT_##signal)(WRITE_DDR(axis, port, bit))
#include BOARD_FILE
#undef WANT_CLOCK_OUT
}

static void let_match_make(uint8_t output_bits)
{
    TCCR2A = (uint8_t)(output_bits | _BV(WGM21));
}

static void start(const struct clock_out_plan *plan)
{
    uint8_t top = (uint8_t)(plan->counts - 1u);

    TCNT2 = 0;
    OCR2A = top;
    OCR2B = top;
    TIFR2 = MATCH_FLAG;
    slow.matches = plan->matches;
    slow.left = plan->matches;
    slow.high = false;
    let_match_make(plan->matches == 1 ? OUTPUT_TOGGLE_BITS : OUTPUT_LOW_BITS);
    TCCR2B = plan->select;
}

void clock_out_set(uint16_t hz)
{
    if (hz == set_hz) {
        return;
    }
    set_hz = hz;
    slow.matches = 1;
    TCCR2B = 0;
    TCCR2A = 0;
    make_pin_output(hz != 0);
    if (hz != 0) {
        struct clock_out_plan plan = clock_out_plan_of(hz, CONFIG_TIMER_HZ);
        start(&plan);
    }
}

// The output keeps its level through all matches but the last one of a half period.
void clock_out_poll(void)
{
    if (slow.matches == 1 || (TIFR2 & MATCH_FLAG) == 0) {
        return;
    }
    TIFR2 = MATCH_FLAG;
    slow.left--;
    if (slow.left == 0) {
        slow.left = slow.matches;
    }
    if (slow.left == 1) {
        slow.high = !slow.high;
        let_match_make(slow.high ? OUTPUT_HIGH_BITS : OUTPUT_LOW_BITS);
    }
}

#endif
