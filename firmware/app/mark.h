// SPDX-License-Identifier: MIT
// The mark: every board on the bus notes which edge of the pixel clock is its newest one, and how
// long before the end of command `mark` that edge came. The command is broadcast and ends at the
// same instant everywhere, so that the host can tell which number each board has for one and the
// same edge. Main loop only.
//
//     clock      |         |         |         |
//     board 1   5300      5301      5302      5303      noted: 5302, 0.4 periods
//     board 2   471       472       473       474       noted: 473, 0.4 periods
//     bus                      [mark]   ^ its end
//
// A board may handle the command some edges later: the newest edge then lies after the end, and the
// noted time is negative.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "config.h" // FEATURE_TOKENS

// `ticks` of a clock that rests.
#define MARK_RESTS INT32_MAX

struct mark {
    // From the newest edge to the end of the command, ticks; MARK_RESTS: the clock rests.
    int32_t ticks;
    // Number of that edge (reference_number()).
    uint16_t edge;
    // Number of the edge that is line zero of the line that began last.
    uint16_t zero_edge;
    // Marks since reset; wraps.
    uint8_t count;
    // Since the mark every edge came as it should. Not so: an edge came at an odd distance or was
    // lost, or the clock has stopped, which may have changed this board's count alone; or there was
    // no mark yet.
    bool steady;
};

#if FEATURE_TOKENS

const struct mark *mark_now(void);

// A command ended just now that asks for a mark: the newest byte of the bus was its last one.
void mark_set(void);

// Make the mark that was asked for, if one was. Once a round, when the clock edges that waited are
// taken: they may be older than the command's end.
void mark_poll(void);

// The clock was disturbed.
void mark_disturb(void);

// Lines begin on this edge.
void mark_zero(uint16_t edge);

#else

static inline void mark_poll(void)
{
}

static inline void mark_disturb(void)
{
}

static inline void mark_zero(uint16_t edge)
{
    (void)edge;
}

#endif
