// SPDX-License-Identifier: MIT
// Places line zero: every armed axis begins at the same instant, a whole number of pixel periods
// after a pixel clock edge (one period, if that leaves enough time). Several boards begin together
// on the edge that `go` has named to each of them. Main loop only.
//
//     clock   __/~~\_______/~~\_______/~~\___
//               ^ start_on_edge()     (an axis needs START_MIN_TICKS)
//               ARMED -> STARTING  ^ start_poll() releases the line
//                                     ^ line zero: the first pixel begins
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "build_features.h" // FEATURE_CLOCK_STATISTICS
#include "config.h"         // CONFIG_AXES

// A pixel clock edge came at edge_ticks, and start_any_waits() is true. Armed axes that wait for an
// edge get their line zero: the edge that `go` has named, once it is near; where none is named, a
// few edges on, if all axes have filled their rings.
void start_on_edge(uint32_t edge_ticks);

// True when every axis that waits for a clock edge can begin: it is decoded ahead, its driver has
// settled, and the clock is known where lines are locked to it.
bool start_ready(void);

#if FEATURE_TOKENS
// Release the axes that wait for a token. Lines that do not wait for the clock begin at once. Lines
// that wait for the clock begin on the clock edge of this number. They wait for that edge as long
// as the clock rests; from the clock's first edge on the clock must go on without a flaw. Where the
// lines cannot begin on that edge, because an axis is not ready or the edge has passed, the board
// latches a fault.
void start_go(uint16_t edge);
#endif

// True when lines wait for a clock that rests, and may do so for long: nobody has released them
// yet, or they were released for an edge still to come.
bool start_may_wait(void);

// This armed axis does not wait for the pixel clock: it starts as soon as it can.
void start_now(uint8_t axis);

#if FEATURE_CLOCK_STATISTICS
// Axes whose line zero is that of the reference (reference_follow()): a bit for each.
uint8_t start_followers(void);
#endif

// True when an axis is armed and waits for its line zero on a clock edge.
bool start_any_waits(void);

// True when an axis runs, or has its line zero, whose line begins on a clock edge. Of a board with
// a single axis: only where its line needs the clock.
#if CONFIG_AXES > 1
bool start_clocked_axis_begun(void);
#else
static inline bool start_clocked_axis_begun(void)
{
    return !start_any_waits();
}
#endif

// True when an axis runs whose line began on a clock edge: it needs the clock to its end.
bool start_clocked_axis_runs(void);

// True when, on a board with several axes, an axis will be released within a few milliseconds: long
// work must wait.
bool start_near(void);

// Release axes whose line zero is near. Once a round. Returns false when a clock edge that waits
// held an axis up: the caller takes the edges and calls this function again at once.
bool start_poll(void);
