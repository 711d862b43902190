// SPDX-License-Identifier: MIT
// The pixel clock input, which the timer of axis CONFIG_PIXEL_CLOCK_AXIS captures: the hardware
// keeps the count at which the edge came. Main loop only.
//
//     counter   0 ........ ticks ............. TOP | 0 ...
//     clock     ______________/~~~~~~~~~~~~~~~~~~~~~~~~~~~
//                             ^ captured PIXEL_CLOCK_CAPTURE_DELAY_TICKS later
//
// Captured edges wait in a queue, so that a long round of the main loop loses none.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "ring/captured_edge.h" // struct captured_edge
#include "ring/step_engine.h"   // struct engine_sample

#define PIXEL_CLOCK_CAPTURE_DELAY_TICKS ((uint8_t)CAPTURED_EDGE_DELAY_TICKS)

// A captured edge, and the sample of the axis whose account places it.
struct pixel_capture {
    // Counter value, ticks from the start of its period.
    uint16_t ticks;
    // The period in which the edge came: argument of ledger_period_start().
    uint8_t back;
    // What that axis's interrupt had done at the capture.
    struct engine_sample sample;
};

// An edge was captured and not taken. A sample of that axis taken before a result of false is not
// younger than any capture still to come.
bool pixel_clock_waiting(void);

// Take the oldest captured edge. Returns false when there is none.
bool pixel_clock_take(struct pixel_capture *capture);

// True when one of the two below has something to tell.
bool pixel_clock_any_lost(void);

// Number of edges since the last call that found no room among CONFIG_CLOCK_EDGES captured ones;
// 255: that or more.
uint8_t pixel_clock_take_lost(void);

// True when, since the last call, an edge came so close behind another one that it was not
// captured.
bool pixel_clock_take_crowded(void);

// Discard the captured edges. Returns false when there was none.
bool pixel_clock_drop(void);
