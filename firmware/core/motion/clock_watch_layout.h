// SPDX-License-Identifier: MIT
// Where near_edge.S finds the members of struct clock_watch; checked in near_edge.c. The assembler
// reads this file, too: plain numbers only.
//
// Offsets in bytes.
#pragma once

#define CLOCK_WATCH_FOLLOWING  0
#define CLOCK_WATCH_EDGES      2
#define CLOCK_WATCH_EDGE_TICKS 6
#define CLOCK_WATCH_NEXT_TICKS 16
#define CLOCK_WATCH_NEAR       20
#define CLOCK_WATCH_NEAR_TICKS 21
#define CLOCK_WATCH_PIXEL      23
#define CLOCK_WATCH_DIVIDER    25
#define CLOCK_WATCH_PHASE      27
#define CLOCK_WATCH_ERROR      29
#define CLOCK_WATCH_ERROR_MAX  31
#define CLOCK_WATCH_GRID       33
