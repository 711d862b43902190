// SPDX-License-Identifier: MIT
// The board's main loop, round by round: accounts, edges of the clock, the decoder's calls, and the
// interrupts that take their share of the time meanwhile.
#pragma once

#include "guarantee.h"
#include "guarantee_pixel.h"

#define PARTS       256u // a ring has no more
#define NEVER_TICKS 1e300

// An axis: its line, and what of the line is written and not accounted for.
struct axis {
    struct walk walk;
    struct part parts[PARTS];
    uint8_t head, tail, plays; // written, accounted for, being made
    double used;
    uint32_t marks, trains, others;
    double end, last_ticks; // of what is written, and of its last period
    bool opened; // the piece to write is begun, though nothing of it is written
    bool known;  // the job that is to be written next,
    double most; // in a batch of so many steps at most
    struct job next;
};

struct loop {
    const struct guarantee_costs *cost;
    const struct guarantee_board *board;
    struct axis axis[GUARANTEE_AXES];
    uint32_t axes;
    double now;        // ticks from line zero
    double work;       // cycles of the main loop so far
    double edges;      // of the clock that were taken
    double edge_ticks; // between two
    double placed;     // when the newest of them was taken
    uint8_t rounds;
    bool several;
    bool started; // line zero has come: what is written from then on takes time
    // Told of each part when it is written, before what it ends is replaced, and of edges that are
    // lost.
    struct guarantee_verdict *verdict;
};

void loop_begin(struct loop *loop, const struct guarantee_axis *line, uint32_t lines);

// Play until everything is written, or something is late.
void loop_play(struct loop *loop);

// Keep that an axis is late by so much, if nothing was before.
static inline void loop_lose(struct loop *r, const struct axis *a, double late_ticks)
{
    struct guarantee_verdict *v = r->verdict;

    if (v->follows) {
        v->follows = false;
        v->axis = (uint32_t)(a - r->axis);
        v->pixel = a->walk.pixel;
        v->late_ticks = late_ticks;
    }
}
