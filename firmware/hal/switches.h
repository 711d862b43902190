// SPDX-License-Identifier: MIT
// Home and limit switches, and the exact time of one home switch's edge: the analog comparator
// compares the switch's pin with 1.1 V and drives the input capture of timer 1, which belongs to
// axis CONFIG_SWITCH_CAPTURE_AXIS. Without FEATURE_HOMING nothing is captured. Main loop only.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "hal/pixel_clock.h" // struct pixel_capture

// Ticks from an edge at the pin to the counter value captured for it: the comparator's synchroniser
// takes the place of the pin's.
#define SWITCH_CAPTURE_DELAY_TICKS PIXEL_CLOCK_CAPTURE_DELAY_TICKS

// Bits of switches_read().
#define SWITCH_HOME        0x01u
#define SWITCH_LIMIT_MINUS 0x02u
#define SWITCH_LIMIT_PLUS  0x04u
#define SWITCH_ALL         0x07u

struct switch_capture {
    // The edge, captured by the timer's own axis.
    struct pixel_capture edge;
    // What the interrupt of the seeking axis had done a few cycles later.
    struct engine_sample seeker;
};

// Levels of an axis's switch pins, as they are now: a bit is set when its pin is high.
uint8_t switches_read(uint8_t axis);

// From now on capture the first edge of this axis's home switch: to high, or to low. A bounce that
// comes before the interrupt has read that edge takes its place, up to 40 us later. Where the
// pixel clock needs the same timer, edges of the clock are not captured meanwhile.
void switch_capture_start(uint8_t axis, bool to_high);
// End the capture.
void switch_capture_stop(void);

// An edge was captured and not taken.
bool switch_capture_waiting(void);

// Take the first edge since the start, or since the last edge was taken. Returns false when there
// is none.
bool switch_capture_take(struct switch_capture *capture);
