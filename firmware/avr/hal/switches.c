// SPDX-License-Identifier: MIT
#include "hal/switches.h"

#include <avr/io.h>
#include <util/atomic.h>
#include <util/delay_basic.h>

#include "avr/hal/board.h" // BOARD_KEEP
#include "avr/hal/capture.h"
#include "avr/hal/flag_bits.h" // FLAG_SWITCH_*
#include "base/apart.h"        // APART
#include "config.h"            // CONFIG_*

#define READ_BIT(number, port, bit, mask)                                                \
    if (CONFIG_INDEX(axis) == (number) && (PIN##port & _BV(bit)) != 0) {                 \
        levels |= (mask);                                                                \
    }

// NOLINTNEXTLINE(readability-function-*): one statement for each switch of the board file
uint8_t switches_read(uint8_t axis)
{
    uint8_t levels = 0;

#define WANT_HOME        BOARD_WANTED
#define WANT_LIMIT_MINUS BOARD_WANTED
#define WANT_LIMIT_PLUS  BOARD_WANTED
#define BOARD_PIN(signal, number, port, bit, header_pin)                                 \
    BOARD_KEEP(WANT_##signal)(READ_BIT(number, port, bit, SWITCH_##signal))
#include BOARD_FILE
    return levels;
}

// On every part the analog comparator can trigger the capture of timer 1 and of no other timer.
#define BOARD_AXIS(axis, timer)                                                          \
    _Static_assert((timer) != 1 || (axis) == CONFIG_SWITCH_CAPTURE_AXIS,                 \
                   "BOARD_SWITCH_CAPTURE_AXIS is the axis of timer 1");                  \
    _Static_assert((timer) != BOARD_PIXEL_CLOCK_TIMER ||                                 \
                       (axis) == CONFIG_PIXEL_CLOCK_AXIS,                                \
                   "BOARD_PIXEL_CLOCK_AXIS is the axis of BOARD_PIXEL_CLOCK_TIMER");
// The home switch of axis n is on input n of the ADC's multiplexer.
#define BOARD_PIN(signal, axis, port, bit, header_pin)                                   \
    BOARD_KEEP(WANT_##signal)                                                            \
    (_Static_assert((axis) == (bit),                                                     \
                    "an axis's home switch is on the ADC input of its number");)
#undef WANT_LIMIT_MINUS
#undef WANT_LIMIT_PLUS
#include BOARD_FILE
#undef WANT_HOME

#if FEATURE_HOMING

#if CONFIG_PIXEL_CLOCK_AXIS == CONFIG_SWITCH_CAPTURE_AXIS
// One timer's capture serves both: the switch during a seek, else the pixel clock. The edges behind
// the oldest one that waits are a switch's bounces.
bool switch_capture_take(struct switch_capture *capture)
{
    // Nothing is dropped behind an empty queue: the first edge may come now.
    if (!pixel_clock_take(&capture->edge)) {
        return false;
    }
    if (CONFIG_AXES > 1) {
        capture->seeker = capture->edge.sample;
    }
    (void)pixel_clock_drop();
    return true;
}

static void drop_capture(void)
{
    (void)pixel_clock_drop();
}

static void enable_capture(uint8_t axis, bool on)
{
    (void)axis;
    (void)on;
    TIFR1 = (uint8_t)_BV(ICF1);
}

bool switch_capture_waiting(void)
{
    return pixel_clock_waiting();
}
#else
static volatile uint8_t seeker_axis;
static struct engine_sample seeker_sample;

static inline void note_seeker(void)
{
    seeker_sample = step_isr_sample(seeker_axis);
}

CAPTURE_HANDLER_AT_ONCE(switch_edge,
                        1,
                        CONFIG_SWITCH_CAPTURE_AXIS,
                        FLAG_SWITCH_BUSY,
                        FLAG_SWITCH_OVERRUN,
                        note_seeker())

bool switch_capture_take(struct switch_capture *capture)
{
    if (!switch_edge.waiting) {
        return false;
    }
    // Before the edge is taken: right behind that a bounce may write a sample of its own.
    capture->seeker = seeker_sample;
    __asm__ volatile("" ::: "memory");
    return capture_take(&switch_edge, &capture->edge, FLAG_SWITCH_BUSY);
}

static void drop_capture(void)
{
    struct switch_capture stale;

    (void)switch_capture_take(&stale);
}

static void enable_capture(uint8_t axis, bool on)
{
    seeker_axis = axis;
    ATOMIC_BLOCK(ATOMIC_RESTORESTATE)
    {
        TIMSK1 = (uint8_t)(on ? TIMSK1 | _BV(ICIE1) : TIMSK1 & ~_BV(ICIE1));
        TIFR1 = (uint8_t)_BV(ICF1);
    }
}

bool switch_capture_waiting(void)
{
    return switch_edge.waiting;
}
#endif

// Selecting an input or the direction of the edge can make an edge by itself. A capture from the
// time before the comparator and the capture unit have settled is therefore dropped.
#define SETTLE_LOOPS 6 // of three cycles

static APART void choose_input(uint8_t axis, uint8_t comparator, bool rising)
{
    ADCSRB = (uint8_t)_BV(ACME);
    ADMUX = axis; // the input of that number
    ACSR = comparator;
    TCCR1B = (uint8_t)(rising ? TCCR1B | _BV(ICES1) : TCCR1B & ~_BV(ICES1));
    _delay_loop_1(SETTLE_LOOPS);
    enable_capture(axis, (comparator & _BV(ACIC)) != 0);
    drop_capture();
}

// The comparator compares the pin with the bandgap reference: its output is low while the pin is
// above the reference, so that a rising pin is a falling edge of the output.
void switch_capture_start(uint8_t axis, bool to_high)
{
    choose_input(axis, (uint8_t)(_BV(ACBG) | _BV(ACIC)), !to_high);
}

// The reference stays on: when switched on, it takes 70 us to settle and could make an edge
// meanwhile.
void switch_capture_stop(void)
{
    choose_input(0, (uint8_t)_BV(ACBG), true);
}

#endif
