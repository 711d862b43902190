// SPDX-License-Identifier: MIT
// One axis of core with a virtual step interrupt behind its ring, advanced period by
// period.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "axis/axis.h"          // struct axis
#include "clock/pixel_period.h" // struct pixel_period
#include "ring/step_engine.h"   // struct step_load

#define BENCH_SLOTS       128u
#define BENCH_DELAY_TICKS 1000u

// The ring lies on a boundary of 256 bytes: so many bytes and one more lie between that and the
// axis. Assembly that reckons with the two bytes of an address apart is right at any of them.
#if !defined(BENCH_SHIFT)
#define BENCH_SHIFT 0u
#endif

struct axis_bench {
    struct step_ring ring;
    uint8_t shift[BENCH_SHIFT + 1u];
    struct axis axis;
    uint32_t now_ticks;  // start of the period that is loaded next
    uint32_t zero_ticks; // line zero of the line released last
    int32_t steps;       // signed STEP edges so far
    struct pixel_period period;
    struct line_limits limits;
    struct step_engine engine;
    uint8_t queue_bytes[4u * BENCH_SLOTS];
    uint16_t divider; // clock edges of a pixel; 0: a line must not change them
    uint8_t budget;   // of each call of the decoder; 0: that of a round
};

extern struct axis_bench bench;

// A fresh axis at this frequency of the clock, 16 MHz timers. A line may change how many of its
// edges are a pixel to the line check; the period of the decoder stays.
void bench_open(uint32_t hz_num, uint32_t hz_den);

// Steps of an even piece before it is handed over as a pulse train. A single axis has none.
void bench_stagger(uint8_t steps);

#define BENCH_BLOCK_MAX 242u

// A block of entries, packed or as runs.
enum block_result bench_queue_block(uint16_t number,
                                    const uint8_t *bytes,
                                    uint8_t size,
                                    bool packed);

// A block of one entry with the block number that is due.
enum block_result bench_queue(int16_t count, uint16_t repeat);

// A line of equal pixels; true when every entry was taken.
bool bench_queue_run(int16_t mark, int16_t count, uint16_t pixels);

// The worked example's entries; true when every one was taken.
bool bench_queue_worked_example(uint16_t backlash_steps);

// Arm, decode ahead, publish: line zero is BENCH_DELAY_TICKS after the next period's
// start.
bool bench_start_line(void);

// Decode, load one period, follow it with the ledger.
struct step_load bench_period(void);

// The state changes that the application makes at a line's end; true when there was one.
bool bench_finish_line(void);
