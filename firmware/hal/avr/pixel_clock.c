// SPDX-License-Identifier: MIT
// Input capture of the pixel clock. The counter restarts in every period, so the handler also says
// in which period the edge fell.
#include "hal/pixel_clock.h"

#include <avr/interrupt.h>
#include <avr/io.h>
#include <util/atomic.h>

#include "config.h"           // CONFIG_BOARD_*
#include "hal/avr/step_isr.h" // step_engines

#if defined(CONFIG_BOARD_UNO)
#define CAPTURE_VECTOR   TIMER1_CAPT_vect
#define CAPTURE_REGISTER ICR1
#define COUNTER          TCNT1
#define FLAGS            TIFR1
#define OVERFLOW_BIT     TOV1
#else
#define CAPTURE_VECTOR   TIMER5_CAPT_vect
#define CAPTURE_REGISTER ICR5
#define COUNTER          TCNT5
#define FLAGS            TIFR5
#define OVERFLOW_BIT     TOV5
#endif

static volatile bool waiting;
static volatile bool overrun;
static struct pixel_capture newest;

// m is the period whose interrupt was served last; it loaded m + 1.
//
//     served:      m         (m + 1 begins, overflow pending)
//     counter   ---|---------------|------
//     edge in m: no overflow pending, or the captured value is beyond the counter
//     edge in m + 1: overflow pending and the captured value is not beyond the counter
//
// The counter is read before and after the flag, so that a wrap in between cannot mislead.
// Budget: 120 cycles, once a pixel.
ISR(CAPTURE_VECTOR)
{
    uint16_t captured = CAPTURE_REGISTER;
    uint16_t before = COUNTER;
    bool wrapped = (FLAGS & _BV(OVERFLOW_BIT)) != 0;
    uint16_t after = COUNTER;
    uint8_t back = 1;

    if (wrapped) {
        back = captured <= after ? 0 : 1;
    } else if (captured > before) {
        back = 2;
    }
    if (waiting) {
        overrun = true;
        return;
    }
    newest.ticks = captured;
    newest.back = back;
    newest.sample.tail = step_engines[CONFIG_PIXEL_CLOCK_AXIS].tail;
    newest.sample.idle_count = step_engines[CONFIG_PIXEL_CLOCK_AXIS].idle_count;
    waiting = true;
}

bool pixel_clock_waiting(void)
{
    return waiting;
}

bool pixel_clock_take(struct pixel_capture *capture, bool *lost)
{
    if (!waiting) {
        return false;
    }
    ATOMIC_BLOCK(ATOMIC_RESTORESTATE)
    {
        *capture = newest;
        *lost = overrun;
        overrun = false;
        waiting = false;
    }
    return true;
}
