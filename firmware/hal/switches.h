// SPDX-License-Identifier: MIT
// Home and limit switches, and the exact time of one home switch's edge: the analog comparator
// compares its pin with 1.1 V and drives the input capture of timer 1, which belongs to axis
// CONFIG_SWITCH_CAPTURE_AXIS. Without FEATURE_HOMING nothing captures. Main loop only.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "hal/pixel_clock.h" // struct pixel_capture

// Ticks from an edge at the pin to the counter value captured for it: the comparator's synchroniser
// takes the place of the pin's.
#define SWITCH_CAPTURE_DELAY_TICKS PIXEL_CLOCK_CAPTURE_DELAY_TICKS

#define SWITCH_HOME        0x01u
#define SWITCH_LIMIT_MINUS 0x02u
#define SWITCH_LIMIT_PLUS  0x04u
#define SWITCH_ALL         0x07u

struct switch_capture {
    struct pixel_capture edge;   // of the timer's own axis
    struct engine_sample seeker; // of the axis whose switch it is, a few cycles later
};

// Levels of an axis's pins as they are: set for high.
uint8_t switches_read(uint8_t axis);

// From now on the first edge of this axis's home switch is captured: to high, or to low. Where the
// pixel clock needs the same timer it is not seen meanwhile.
void switch_capture_start(uint8_t axis, bool to_high);
void switch_capture_stop(void);

// True when an edge was captured and not taken.
bool switch_capture_waiting(void);

// The first edge since the start or since the last one was taken.
bool switch_capture_take(struct switch_capture *capture);
