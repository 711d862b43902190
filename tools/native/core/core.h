// SPDX-License-Identifier: MIT
// The firmware's motion core for the host tools: its line check, and the ticks that its decoder
// makes. The same sources as in a board's image, so that the host and the board cannot disagree.
//
//     entries --> checker_begin() --> checker_more() ... --> checker_end()
//     entries --> plan_begin() --> plan_rows() until plan_over() --> plan_end()
//
// entries: those of a line as a board gets it, see line/segment.h.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "line/line_check.h" // struct line_limits
#include "line/segment.h"    // struct segment

struct core_finding {
    // enum line_error: an error, or from 32 on a warning.
    uint32_t code;
    // 1-based; of an end mark the pixel behind the last one.
    uint32_t pixel;
};

struct checker;

// Begin to check a line, whose entries may come in parts. Returns NULL when there is no memory.
struct checker *checker_begin(const struct line_limits *limits);

// Check the entries that follow and write at most `room` findings to `found`. Returns their number.
//
// The first error is the one that a board gives, and every error refuses the line. So that a user
// sees several mistakes at once, the check continues behind an entry that exceeds a limit, as if
// there were no such limit, and behind equal counts that oscillate. Behind any other error it ends.
uint32_t checker_more(struct checker *checker,
                      const struct segment *entries,
                      uint32_t entry_count,
                      struct core_finding *found,
                      uint32_t room);

// Free what checker_begin() made.
void checker_end(struct checker *checker);

struct plan;

// Begin to plan a line that the check passes. `entries` must last until plan_end(). Returns NULL
// when the pixel period is none that a board can carry, or when there is no memory.
//
// pixels: false for a row (tick) for each STEP edge, true for a row (tick, expected position) for
// each pixel edge. Tick 0 is line zero.
struct plan *plan_begin(uint32_t timer_hz,
                        uint32_t hz_num,
                        uint32_t hz_den,
                        const struct line_limits *limits,
                        const struct segment *entries,
                        uint32_t entry_count,
                        bool pixels);

// The fewest values that plan_rows() needs room for.
#define PLAN_MIN_ROOM 64u

// Plan on until `values` is full, the line ends, or some 10 ms have passed, so that the caller can
// heed a signal. Returns the number of values written, -1 when the core breaks a promise of its
// own. The time that all calls take grows with edges of steps and pixels, not with the time between
// them.
int32_t plan_rows(struct plan *plan, int64_t *values, uint32_t room);

// True when all rows of the line have been written.
bool plan_over(const struct plan *plan);

// Free what plan_begin() made.
void plan_end(struct plan *plan);
