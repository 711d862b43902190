// SPDX-License-Identifier: MIT
// Compile-time choices of the firmware: default, unit, range. Settings that a host may change are
// in core/wire/registers.def instead.
#pragma once

#include BOARD_FILE         // the board's constants, BOARD_...; the build names the file
#include "build_features.h" // FEATURE_*

// Version, reported by function 17 and input register 1.
#define CONFIG_VERSION_MAJOR 0
#define CONFIG_VERSION_MINOR 1

// Timer ticks a second; prescaler 1, so the CPU clock.
#define CONFIG_TIMER_HZ (BOARD_CPU_HZ + 0uL)
#if CONFIG_TIMER_HZ % 1000000uL != 0
#error "a microsecond must have a whole number of timer ticks"
#endif

// STEP is low for this many ticks from the start of each period, then rises; at least 3. With the
// tick in which it rises, 2 us.
#define CONFIG_PULSE_LOW_TICKS ((unsigned)(CONFIG_TIMER_HZ / 500000uL - 1u))

// Axes, queue and shortest intervals of the board. An entry must reach OCRnA before its period
// begins, so an interval must be longer than everything that can keep the step interrupt waiting
// at once and the handler's own way to OCRnA. Cycles (uno, mega, m1284); `pixstep bench --only
// waits` and `--only handlers` measure them:
//
//     interrupts off in the main loop, or in a serial handler   13    28    26
//     pixel clock capture, until it lets others in              26    28    27
//     step handlers of the other axes                            -   147    49   49 each
//     a train's period, from the flag's service to OCRnA        23    25    23
//                                                               --   ---   ---
//                                                               62   228   125
//
// Axes at rest are parked and interrupt nobody: with fewer axes moving an interval may be shorter
// (DESIGN.md, "Time and account"). The waits of a coincidence can then be longer than the interval;
// a train catches up (step_catch_up.inc).
//
// Where several axes move the capture takes 18 cycles more if it comes with the overflow of its own
// timer. A single period takes 29 (31) cycles to OCRnA, so that only pulse trains make the shortest
// periods (decode.c). The other axes take up to 80 cycles where they begin a train. They begin
// their trains some steps apart from each other (TRAIN_STAGGER_STEPS), but lines of different rates
// can meet all the same. An interrupt that is then late by less than a period is an underrun, which
// the handler sees before the edge; time_check.c sees one that is late by a whole period.
//
// Smooth lines have a limit of their own: in them a pulse train can follow single
// periods, and the step interrupt needs longer to load its first interval than to go on with
// single periods or with a pulse train (TRAIN_ENTRY_MIN_TICKS in axis.c).
// The capture interrupt tells apart the periods around an edge as long as no more than one began
// since: a seek must be slower than its longest way, with every step interrupt in between. Edges
// were placed wrong at 160 ticks on the Uno and 320 on the Mega, right at 200 and 400. A board of
// two axes lies between them.
//
// A reversal has the driver's set-up and hold times on both sides of its middle, and so many ticks
// more: the direction output changes that long after the middle at most. One axis's commands take
// 370 ticks on the Uno and 630 on the Mega; there four axes that reverse at once take 1530, and a
// byte on the bus may come between (test_turns.py reverses all of them at the limit).
#define CONFIG_BOARD_NAME          BOARD_NAME
#define CONFIG_BOARD_ID            BOARD_ID
#define CONFIG_AXES                BOARD_AXES
#define CONFIG_PIXEL_CLOCK_AXIS    BOARD_PIXEL_CLOCK_AXIS
#define CONFIG_SWITCH_CAPTURE_AXIS BOARD_SWITCH_CAPTURE_AXIS
#define CONFIG_QUEUE_ENTRIES      BOARD_QUEUE_ENTRIES // runs and marks per axis, at least
#define CONFIG_QUEUE_BYTES        (CONFIG_QUEUE_ENTRIES * 4u)
#define CONFIG_EVENTS             BOARD_EVENTS // kept in the event log
#define CONFIG_MIN_INTERVAL_TICKS (BOARD_MIN_INTERVAL_TICKS + 0u)
#define CONFIG_SMOOTH_MIN_INTERVAL_TICKS (BOARD_SMOOTH_MIN_INTERVAL_TICKS + 0u)
// The same while only 1, 2 or 3 axes are armed or move, on a board with more axes.
#if !defined(BOARD_MIN_INTERVAL_1_TICKS)
#define BOARD_MIN_INTERVAL_1_TICKS        BOARD_MIN_INTERVAL_TICKS
#define BOARD_SMOOTH_MIN_INTERVAL_1_TICKS BOARD_SMOOTH_MIN_INTERVAL_TICKS
#endif
#if !defined(BOARD_MIN_INTERVAL_2_TICKS)
#define BOARD_MIN_INTERVAL_2_TICKS        BOARD_MIN_INTERVAL_TICKS
#define BOARD_SMOOTH_MIN_INTERVAL_2_TICKS BOARD_SMOOTH_MIN_INTERVAL_TICKS
#endif
#if !defined(BOARD_MIN_INTERVAL_3_TICKS)
#define BOARD_MIN_INTERVAL_3_TICKS        BOARD_MIN_INTERVAL_TICKS
#define BOARD_SMOOTH_MIN_INTERVAL_3_TICKS BOARD_SMOOTH_MIN_INTERVAL_TICKS
#endif
#define CONFIG_SEEK_MIN_INTERVAL_TICKS (BOARD_SEEK_MIN_INTERVAL_TICKS + 0u)
#define CONFIG_REVERSAL_MARGIN_TICKS   ((uint32_t)BOARD_REVERSAL_MARGIN_TICKS)

// Edges of the pixel clock that are captured and not taken.
#define CONFIG_CLOCK_EDGES 8

// An axis's place in an array of axes: with a single one it is known when the image is built.
#if CONFIG_AXES == 1
#define CONFIG_INDEX(axis) ((void)(axis), (uint8_t)0)
#else
#define CONFIG_INDEX(axis) ((uint8_t)(axis))
#endif

#if (BOARD_QUEUE_ENTRIES & (BOARD_QUEUE_ENTRIES - 1)) != 0 || BOARD_QUEUE_ENTRIES < 2
#error "BOARD_QUEUE_ENTRIES must be a power of two from 2 on"
#endif
