// SPDX-License-Identifier: MIT
// The pixel clock that the board makes itself (setting `clock_out_hz`). An 8-bit timer runs freely;
// a match comes each time that its count reaches the compare register. The timer's interrupt moves
// the register on from match to match and decides ahead which level the next match makes. Where the
// output is the timer's own pin, the hardware then changes the level at the match, however late the
// interrupt runs.
//
// avr/hal/clock_out.c makes the clock. The main loop begins a clock while the interrupt is off;
// from then on only the interrupt calls the other functions. All lengths are counts of the timer; a
// count is as long as a unit of the coarse clock (hal/clock.h).
//
//     left       600      344   172 0                        a period of 1200 counts
//     match      |----256--|-172-|-172-|-----256-----|--
//     output     __________________/~~~~~~~~~~~~~~~~~~~~
//
// A match that is not an edge makes the level that the output has already. The functions are inline
// so that the timer's interrupt saves only the registers that it needs.
#pragma once

#include <stdbool.h>
#include <stdint.h>

// Slowest and fastest clock, Hz.
#define CLOCK_OUT_HZ_MIN 1u
#define CLOCK_OUT_HZ_MAX 2000u

// Shortest and longest distance from a match to the next, counts. The interrupt must move the
// register on within the shortest. The longest is one turn of the timer's 8 bits.
#define CLOCK_OUT_COUNTS_MIN 62u
#define CLOCK_OUT_COUNTS_MAX 256u

// The state of the clock. While the clock runs only the interrupt writes it.
struct clock_out {
    // Counts from the last match to the next edge; never 0 while the clock runs.
    uint32_t left_counts;
    // Counts of a period, from 125 at the fastest clock up to 312,500; 0: no clock is made.
    uint32_t period_counts : 24;
    // Level of the output since the last match.
    bool high : 1;
};

// Counts of the level that the output has now: half of a period. Of an odd number of counts the low
// level takes the one more.
static inline uint32_t clock_out_level_counts(const struct clock_out *clock)
{
    return (clock->period_counts + (clock->high ? 0u : 1u)) / 2u;
}

// Counts of the period of a clock of `hz` (CLOCK_OUT_HZ_MIN..CLOCK_OUT_HZ_MAX), rounded to the
// nearest count. counts_hz: counts of the timer in a second, 250,000 to 312,500. Divides.
static inline uint32_t clock_out_period_counts(uint16_t hz, uint32_t counts_hz)
{
    return (counts_hz + hz / 2u) / hz;
}

// Begin a clock with a low level; the present count is the place of its first match. period_counts:
// the result of clock_out_period_counts(), or 0 for no clock; then the functions below must not be
// called. The timer's interrupt must be off.
static inline void clock_out_begin(struct clock_out *clock, uint32_t period_counts)
{
    clock->period_counts = period_counts & 0xFFFFFFu;
    clock->high = false;
    clock->left_counts = clock_out_level_counts(clock);
}

// Counts from the last match to the next, CLOCK_OUT_COUNTS_MIN..CLOCK_OUT_COUNTS_MAX. Where a whole
// turn would leave too little time for the last match before the edge, what is left is divided into
// two matches.
static inline uint16_t clock_out_counts(const struct clock_out *clock)
{
    if (clock->left_counts > CLOCK_OUT_COUNTS_MAX + CLOCK_OUT_COUNTS_MIN) {
        return CLOCK_OUT_COUNTS_MAX;
    }
    uint16_t left = (uint16_t)clock->left_counts;

    return left > CLOCK_OUT_COUNTS_MAX ? left / 2u : left;
}

// The level that the next match makes: the other level if that match is an edge, else the same.
static inline bool clock_out_next_level(const struct clock_out *clock)
{
    return clock->high != (clock->left_counts <= CLOCK_OUT_COUNTS_MAX);
}

// The next match has come: go on to it. Once for each match, in the timer's interrupt.
static inline void clock_out_match(struct clock_out *clock)
{
    clock->left_counts -= clock_out_counts(clock);
    if (clock->left_counts == 0) {
        clock->high = !clock->high;
        clock->left_counts = clock_out_level_counts(clock);
    }
}
