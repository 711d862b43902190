// SPDX-License-Identifier: MIT
// The edges of a clock that the board makes itself, from matches of an 8-bit timer that runs
// freely: a match comes each time that the count reaches the compare register. The register is
// moved on from match to match, and what the next match makes of the output is said ahead, so that
// the hardware changes the level and not the program.
//
//     left       600      344   172 0                        a period of 1200 counts
//     match      |----256--|-172-|-172-|-----256-----|--
//     output     __________________/~~~~~~~~~~~~~~~~~~~~
//
// A match that is not an edge makes the level that there is already. In the header, so that the
// timer's interrupt saves only the registers that it needs.
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
    // Counts from the last match to the next edge.
    uint32_t left_counts;
    // Counts of a period.
    uint32_t period_counts : 24;
    // Level since the last match.
    bool high : 1;
};

// Counts of the level that begins now: half of a period, the low one a count longer if need be.
static inline uint32_t clock_out_level_counts(const struct clock_out *clock)
{
    return (clock->period_counts + (clock->high ? 0u : 1u)) / 2u;
}

// Counts of a period of CLOCK_OUT_HZ_MIN..CLOCK_OUT_HZ_MAX, the nearest ones, of a timer that
// counts 250,000 to 312,500 times a second. Divides.
static inline uint32_t clock_out_period_counts(uint16_t hz, uint32_t counts_hz)
{
    return (counts_hz + hz / 2u) / hz;
}

// Begin a clock with a low level: now is its first match.
static inline void clock_out_begin(struct clock_out *clock, uint32_t period_counts)
{
    clock->period_counts = period_counts & 0xFFFFFFu;
    clock->high = false;
    clock->left_counts = clock_out_level_counts(clock);
}

// Counts to the next match, CLOCK_OUT_COUNTS_MIN..CLOCK_OUT_COUNTS_MAX. What is left for the last
// match before an edge must not be too short.
static inline uint16_t clock_out_counts(const struct clock_out *clock)
{
    if (clock->left_counts > CLOCK_OUT_COUNTS_MAX + CLOCK_OUT_COUNTS_MIN) {
        return CLOCK_OUT_COUNTS_MAX;
    }
    uint16_t left = (uint16_t)clock->left_counts;

    return left > CLOCK_OUT_COUNTS_MAX ? left / 2u : left;
}

// The level that the next match makes.
static inline bool clock_out_next_level(const struct clock_out *clock)
{
    return clock->high != (clock->left_counts <= CLOCK_OUT_COUNTS_MAX);
}

// The next match has come.
static inline void clock_out_match(struct clock_out *clock)
{
    clock->left_counts -= clock_out_counts(clock);
    if (clock->left_counts == 0) {
        clock->high = !clock->high;
        clock->left_counts = clock_out_level_counts(clock);
    }
}
