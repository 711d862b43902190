// SPDX-License-Identifier: MIT
// Compile-time choices of the firmware: default, unit, range. Settings that a host may change are
// in core/wire/registers.def instead.
#pragma once

#include "build_features.h" // FEATURE_*

// Version, reported by function 17 and input register 1.
#define CONFIG_VERSION_MAJOR 0
#define CONFIG_VERSION_MINOR 1

// Timer ticks a second; prescaler 1, so the CPU clock.
#define CONFIG_TIMER_HZ 16000000uL

// STEP is low for this many ticks from the start of each period, then rises; at least 3.
#define CONFIG_PULSE_LOW_TICKS 31u

// Axes, queue and shortest intervals of each board. An entry must reach OCRnA before its period
// begins, so an interval must be longer than everything that can keep the step interrupt waiting
// at once and the handler's own way to OCRnA. Cycles (uno, mega); `pixstep bench --only waits` and
// `--only handlers` measure them:
//
//     interrupts off in the main loop, or in a serial handler   21    21
//     pixel clock capture, until it lets others in              13    14
//     step handlers of the other axes                            -   141   3 x 47
//     a run's period, from the flag's service to OCRnA          23    25
//                                                               --   ---
//                                                               57   201
//
// A single period takes 29 (31) cycles to OCRnA; so short ones are only made by runs (axis.c).
// The other axes take up to 86 cycles where they begin a run. They do so some steps apart from each
// other (RUN_STAGGER_STEPS), but lines of different rates can meet all the same. What is then late
// by less than a period is an underrun, seen by the handler before the edge; what is late by a
// whole one is seen by time_check.c.
//
// Smooth lines have a limit of their own: in them a run of constant steps can follow single
// periods, and the step interrupt needs longer to load its first interval than to go on with
// single periods or with a run (RUN_ENTRY_MIN_TICKS in axis.c).
// The capture interrupt tells apart the periods around an edge as long as no more than one began
// since: a seek must be slower than its longest way, with every step interrupt in between. Edges
// were placed wrong at 160 ticks on the Uno and 320 on the Mega, right at 200 and 400.
//
// A reversal has the driver's set-up and hold times on both sides of its middle, and so many ticks
// more: the direction output changes that long after the middle at most. One axis's commands take
// 370 ticks on the Uno and 630 on the Mega; there four axes that turn at once take 1530, and a byte
// on the serial line may come between (test_turns.py turns all of them at the limit).
#if defined(CONFIG_BOARD_UNO)
#define CONFIG_BOARD_NAME                "uno"
#define CONFIG_BOARD_ID                  1
#define CONFIG_AXES                      1
#define CONFIG_PIXEL_CLOCK_AXIS          0
#define CONFIG_SWITCH_CAPTURE_AXIS       0  // the comparator's timer is timer 1
#define CONFIG_QUEUE_ENTRIES             32 // runs and marks per axis
#define CONFIG_EVENTS                    8  // kept in the event log
#define CONFIG_MIN_INTERVAL_TICKS        63u
#define CONFIG_SMOOTH_MIN_INTERVAL_TICKS 120u
#define CONFIG_SEEK_MIN_INTERVAL_TICKS   266u
#define CONFIG_TURN_MARGIN_TICKS         ((uint32_t)512)
#elif defined(CONFIG_BOARD_MEGA)
#define CONFIG_BOARD_NAME                "mega"
#define CONFIG_BOARD_ID                  2
#define CONFIG_AXES                      4
#define CONFIG_PIXEL_CLOCK_AXIS          3
#define CONFIG_SWITCH_CAPTURE_AXIS       0
#define CONFIG_QUEUE_ENTRIES             128
#define CONFIG_EVENTS                    16
#define CONFIG_MIN_INTERVAL_TICKS        266u
#define CONFIG_SMOOTH_MIN_INTERVAL_TICKS 266u
#define CONFIG_SEEK_MIN_INTERVAL_TICKS   400u
#define CONFIG_TURN_MARGIN_TICKS         ((uint32_t)1800)
#else
#error "name the board: CONFIG_BOARD_UNO or CONFIG_BOARD_MEGA"
#endif

// An axis's place in an array of axes: with a single one it is known when the image is built.
#if CONFIG_AXES == 1
#define CONFIG_INDEX(axis) ((void)(axis), (uint8_t)0)
#else
#define CONFIG_INDEX(axis) ((uint8_t)(axis))
#endif

#if (CONFIG_QUEUE_ENTRIES & (CONFIG_QUEUE_ENTRIES - 1)) != 0 || CONFIG_QUEUE_ENTRIES > 128
#error                                                                                   \
    "CONFIG_QUEUE_ENTRIES must be a power of two up to 128: the queue's indices are 8 bits"
#endif
