// SPDX-License-Identifier: MIT
// Places line zero: every armed axis begins at the same instant, a whole number of pixel periods
// after a pixel clock edge (one period, if that leaves enough time). Main loop only.
//
//     clock   __/~~\_______/~~\_______/~~\___
//               ^ start_on_edge()     (an axis needs START_MIN_TICKS)
//               ARMED -> STARTING  ^ start_poll() releases the line
//                                     ^ line zero: the first pixel begins
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "build_features.h" // FEATURE_CLOCK_STATISTICS

// A pixel clock edge came at edge_ticks: armed axes that wait for an edge get their line zero, if
// all of them have filled their rings.
void start_on_edge(uint32_t edge_ticks);

// This armed axis does not wait for the pixel clock: it starts as soon as it can.
void start_now(uint8_t axis);

#if FEATURE_CLOCK_STATISTICS
// Axes whose line zero is that of the reference (reference_follow()): a bit for each.
uint8_t start_followers(void);
#endif

// True when an axis is armed and waits for its line zero on a clock edge.
bool start_any_waits(void);

// True when an axis runs whose line began on a clock edge: it needs the clock to its end.
bool start_clocked_axis_runs(void);

// True when, on a board with several axes, an axis will be released within a few milliseconds: long
// work must wait.
bool start_near(void);

// Release axes whose line zero is near. Once a round; again at once, behind the clock edges that
// wait, if the function returns false: such an edge held an axis up.
bool start_poll(void);
