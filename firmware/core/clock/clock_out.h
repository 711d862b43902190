// SPDX-License-Identifier: MIT
// The edges of a clock that the board makes itself, from matches of an 8-bit timer that runs freely:
// a match comes each time that the count reaches the compare register. The register is moved on from
// match to match, and what the next match makes of the output is said ahead, so that the hardware
// changes the level and not the program.
//
//     left       600      344   172 0                        a period of 1200 counts
//     match      |----256--|-172-|-172-|-----256-----|--
//     output     __________________/~~~~~~~~~~~~~~~~~~~~
//
// A match that is not an edge makes the level that there is already.
#pragma once

#include <stdbool.h>
#include <stdint.h>

// Slowest and fastest clock, Hz.
#define CLOCK_OUT_HZ_MIN 1u
#define CLOCK_OUT_HZ_MAX 2000u

// Counts from a match to the next: the program has so long to move the register on.
#define CLOCK_OUT_COUNTS_MIN 62u
#define CLOCK_OUT_COUNTS_MAX 256u

struct clock_out {
    // Counts for which the clock is low, and high.
    uint32_t low_counts;
    uint32_t high_counts;
    // Counts from the last match to the next edge.
    uint32_t left_counts;
    // Counts from the last match to the next one.
    uint16_t counts;
    // Level since the last match.
    bool high;
};

// Begin a clock of CLOCK_OUT_HZ_MIN..CLOCK_OUT_HZ_MAX on a timer that counts 250,000 to 312,500
// times a second: it is low, and its first edge comes half a period after the match before which
// clock_out_match() is first called. A period is the nearest whole number of counts. Divides.
void clock_out_begin(struct clock_out *clock, uint16_t hz, uint32_t counts_hz);

// A match has come. Returns the counts to the next one, CLOCK_OUT_COUNTS_MIN..CLOCK_OUT_COUNTS_MAX.
uint16_t clock_out_match(struct clock_out *clock);

// The level that the next match makes.
static inline bool clock_out_next_level(const struct clock_out *clock)
{
    return clock->high != (clock->counts == clock->left_counts);
}
