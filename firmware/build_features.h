// SPDX-License-Identifier: MIT
// Which features of build_features.def this image has: all of them on a board with flash for them.
// The smaller board's default keeps everything that a printer's axis needs and leaves out what only
// other Modbus masters use. The build may set any of them to 0 or 1 (-DFEATURE_HOMING=0).
#pragma once

#include BOARD_FILE // BOARD_ALL_FEATURES

// Seeks: lines that end at a home switch, and the command that makes its edge position 0.
#ifndef FEATURE_HOMING
#define FEATURE_HOMING 1
#endif
// Smooth lines that take up backlash in their leading zero pixel.
#ifndef FEATURE_BACKLASH
#define FEATURE_BACKLASH 1
#endif
// Coils and discrete inputs: functions 01, 02, 05, 15.
#ifndef FEATURE_BITS
#define FEATURE_BITS BOARD_ALL_FEATURES
#endif
// Functions 08, 17, 22, 23 and 43/14: counters, identity, masked and combined writes.
#ifndef FEATURE_DIAGNOSIS
#define FEATURE_DIAGNOSIS BOARD_ALL_FEATURES
#endif
// The log of the newest faults and resets.
#ifndef FEATURE_EVENTS
#define FEATURE_EVENTS BOARD_ALL_FEATURES
#endif
// Errors of the pixel clock's edges against the plan of the reference line.
#ifndef FEATURE_CLOCK_STATISTICS
#define FEATURE_CLOCK_STATISTICS BOARD_ALL_FEATURES
#endif
// Settings that outlive the supply, and the command that stores them.
#ifndef FEATURE_STORE
#define FEATURE_STORE 1
#endif
// Start tokens, so that several boards start on one clock edge.
#ifndef FEATURE_TOKENS
#define FEATURE_TOKENS 1
#endif
// Drivers that go off when idle, and lines that wait until a driver has settled.
#ifndef FEATURE_DRIVER_TIMING
#define FEATURE_DRIVER_TIMING 1
#endif
// Function 20: records, events and settings as files.
#ifndef FEATURE_FILES
#define FEATURE_FILES BOARD_ALL_FEATURES
#endif
// Fast smooth pixels computed by 32 bits instead of 40.
#ifndef FEATURE_NARROW_CURVES
#define FEATURE_NARROW_CURVES BOARD_ALL_FEATURES
#endif
// Curved pixels of few steps written as a whole: 4000 cycles a pixel less.
#ifndef FEATURE_SHORT_CURVES
#define FEATURE_SHORT_CURVES BOARD_ALL_FEATURES
#endif
// Clock edges of a pixel in a line's start mark, in the place of a write of setting `divider`.
#ifndef FEATURE_LINE_DIVIDER
#define FEATURE_LINE_DIVIDER BOARD_ALL_FEATURES
#endif
// Setting home_is_limit.
#ifndef FEATURE_SHARED_SWITCH
#define FEATURE_SHARED_SWITCH BOARD_ALL_FEATURES
#endif
// Axes that end at the same line, and a silent bus that acts at a line's end.
#ifndef FEATURE_LINE_ENDS
#define FEATURE_LINE_ENDS BOARD_ALL_FEATURES
#endif
// A pixel clock that the board makes on pin CLOCK_OUT: setting `clock_out_hz`.
#ifndef FEATURE_CLOCK_OUT
#define FEATURE_CLOCK_OUT BOARD_ALL_FEATURES
#endif
// Pixel clocks that come in bursts: setting `gate_edges`. A burst names an edge as `go` does: an
// image without start tokens has no gate.
#ifndef FEATURE_GATE
#define FEATURE_GATE BOARD_ALL_FEATURES
#endif
#if !FEATURE_TOKENS
#undef FEATURE_GATE
#define FEATURE_GATE 0
#endif

// Several axes share the processor: how fast a line may be depends on how many of them move.
#define SEVERAL_AXES (BOARD_AXES > 1)

// Input register `features`: the bit numbers of build_features.def.
#define FEATURES_BITS                                                                    \
    (FEATURE_HOMING << 0 | FEATURE_BACKLASH << 1 | FEATURE_BITS << 2 |                   \
     FEATURE_DIAGNOSIS << 3 | FEATURE_EVENTS << 4 | FEATURE_CLOCK_STATISTICS << 5 |      \
     FEATURE_STORE << 6 | FEATURE_TOKENS << 7 | FEATURE_DRIVER_TIMING << 8 |             \
     FEATURE_FILES << 9 | FEATURE_NARROW_CURVES << 10 | FEATURE_SHORT_CURVES << 11 |     \
     FEATURE_LINE_DIVIDER << 12 | FEATURE_GATE << 13 | FEATURE_SHARED_SWITCH << 14 |     \
     (uint16_t)FEATURE_LINE_ENDS << 15)
// Input register `features_high`: those from 16 on.
#define FEATURES_HIGH_BITS (FEATURE_CLOCK_OUT << 0)
