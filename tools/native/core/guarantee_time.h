// SPDX-License-Identifier: MIT
// Time that passes while the board's main loop works: what interrupts take of it, and what comes
// again in every round.
#pragma once

#include <stdbool.h>

#include "guarantee_loop.h" // struct loop

// Of a pixel, ticks.
static inline double loop_period(const struct loop *r)
{
    return r->board->pixel_ticks;
}

// Share of the processor that interrupts take now; *until: when that may change.
double loop_interrupts(struct loop *r, double *until);

// Let the main loop work for so many cycles.
void loop_spend(struct loop *r, double cycles);

// How long the longest request holds the main loop now, ticks.
double loop_request_ticks(struct loop *r);

// Cycles of a round with nothing to do, and of an edge of the clock that is taken now.
double loop_round_cost(const struct loop *r);
double loop_edge_cost(const struct loop *r);
