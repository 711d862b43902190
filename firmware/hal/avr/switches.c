// SPDX-License-Identifier: MIT
#include "hal/switches.h"

#include <avr/io.h>
#include <util/atomic.h>
#include <util/delay_basic.h>

#include "base/apart.h"    // APART
#include "config.h"        // CONFIG_*
#include "hal/avr/board.h" // BOARD_FILE
#include "hal/avr/capture.h"

// Rows of the board file that are not switches.
#define BOARD_AXIS(axis, timer)
#define READ_STEP(number, port, bit)
#define READ_DIR(number, port, bit)
#define READ_ENABLE(number, port, bit)
#define READ_PIXEL_CLOCK(number, port, bit)
#define READ_PIXEL_CLOCK_COPY(number, port, bit)
#define READ_ESTOP(number, port, bit)
#define READ_RS485_DE(number, port, bit)
#define READ_PERMIT(number, port, bit)
#define READ_BIT(number, port, bit, mask)                                                \
    if (axis == (number) && (PIN##port & _BV(bit)) != 0) {                               \
        levels |= (mask);                                                                \
    }
#define READ_HOME(number, port, bit) READ_BIT(number, port, bit, SWITCH_HOME)
#define READ_LIMIT_MINUS(number, port, bit)                                              \
    READ_BIT(number, port, bit, SWITCH_LIMIT_MINUS)
#define READ_LIMIT_PLUS(number, port, bit) READ_BIT(number, port, bit, SWITCH_LIMIT_PLUS)

// NOLINTNEXTLINE(readability-function-*): one statement for each switch of the board file
uint8_t switches_read(uint8_t axis)
{
    uint8_t levels = 0;

#define BOARD_PIN(signal, axis, port, bit, header_pin) READ_##signal(axis, port, bit)
#include BOARD_FILE
#undef BOARD_PIN
    return levels;
}

#if defined(CONFIG_BOARD_UNO)
// The one timer's capture serves the switch or the pixel clock.
bool switch_capture_take(struct switch_capture *capture)
{
    bool lost = false;
    bool taken = pixel_clock_take(&capture->edge, &lost);

    capture->seeker = capture->edge.sample;
    return taken;
}

static void listen(uint8_t axis, bool on)
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
static struct engine_sample seeker;

static inline void note_seeker(void)
{
    seeker = step_isr_sample(seeker_axis);
}

CAPTURE_HANDLER_AT_ONCE(switch_edge,
                        1,
                        CONFIG_SWITCH_CAPTURE_AXIS,
                        CAPTURE_SWITCH_BUSY,
                        CAPTURE_SWITCH_OVERRUN,
                        note_seeker())

bool switch_capture_take(struct switch_capture *capture)
{
    bool taken = capture_take(&switch_edge, &capture->edge, CAPTURE_SWITCH_BUSY);

    capture->seeker = seeker;
    return taken;
}

static void listen(uint8_t axis, bool on)
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

// Choosing input and edge can make an edge of its own: what was captured before the comparator's
// and the capture's own stages have settled is forgotten.
#define SETTLE_LOOPS 6 // of three cycles

static APART void choose(uint8_t axis, uint8_t comparator, bool rising)
{
    struct switch_capture stale;

    ADCSRB = (uint8_t)_BV(ACME);
    ADMUX = axis; // home switches lie on the multiplexer's inputs of their axes' numbers
    ACSR = comparator;
    TCCR1B = (uint8_t)(rising ? TCCR1B | _BV(ICES1) : TCCR1B & ~_BV(ICES1));
    _delay_loop_1(SETTLE_LOOPS);
    listen(axis, (comparator & _BV(ACIC)) != 0);
    (void)switch_capture_take(&stale);
}

// The pin is compared with the bandgap reference: above it the comparator's output is low.
void switch_capture_start(uint8_t axis, bool to_high)
{
    choose(axis, (uint8_t)(_BV(ACBG) | _BV(ACIC)), !to_high);
}

// The reference stays on: it takes 70 us to settle, and would be an edge meanwhile.
void switch_capture_stop(void)
{
    choose(0, (uint8_t)_BV(ACBG), true);
}
