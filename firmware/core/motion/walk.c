// SPDX-License-Identifier: MIT
#include "motion/walk.h"

#define NO_EDGE 0xFFFFu

// Special steps: the two around the edge, the one after them (it sees their shift), the last.
static uint16_t next_special(const struct walk *walk)
{
    uint16_t next = walk->count;

    if (walk->edge_steps != NO_EDGE) {
        for (uint8_t after = 0; after < 3; after++) {
            uint16_t candidate = (uint16_t)(walk->edge_steps + after);
            if (candidate > walk->index && candidate < next) {
                next = candidate;
                break;
            }
        }
    }
    return next;
}

void walk_start(struct walk *walk, const struct piece *piece)
{
    walk->curved = piece->curved;
    walk->at_edge = false;
    walk->index = 0;
    walk->count = piece->steps;
    walk->edge_steps = piece->has_edge ? piece->edge_steps : NO_EDGE;
    walk->edge_ticks = piece->edge_ticks;
    walk->end_ticks = piece->ticks;
    walk->exact_ticks = 0;
    walk->skew_ticks = 0;
    walk->last_special = next_special(walk);
    walk->until = walk->last_special;
    if (piece->curved) {
        curve_start(&walk->steps.curve, piece->ticks, piece->start_speed, piece->steps);
    } else {
        even_start(&walk->steps.even, piece->ticks, piece->steps);
    }
}

static uint32_t place_special(const struct walk *walk)
{
    uint32_t tick = walk->exact_ticks;

    if (walk->index == walk->count) {
        tick = walk->end_ticks;
    } else if (walk->index == walk->edge_steps && tick > walk->edge_ticks) {
        tick = walk->edge_ticks;
    } else if (walk->index == (uint16_t)(walk->edge_steps + 1u) &&
               tick <= walk->edge_ticks) {
        tick = walk->edge_ticks + 1u;
    }
    return tick;
}

static uint32_t special(struct walk *walk, uint32_t before_ticks)
{
    walk->index = walk->last_special;
    uint32_t tick = place_special(walk);
    uint32_t interval = tick - before_ticks - (uint32_t)walk->skew_ticks;

    walk->skew_ticks = (int32_t)(tick - walk->exact_ticks);
    walk->at_edge = walk->index == walk->edge_steps;
    if (walk->index < walk->count) {
        walk->last_special = next_special(walk);
        walk->until = (uint16_t)(walk->last_special - walk->index);
    }
    return interval;
}

uint32_t walk_next(struct walk *walk)
{
    uint32_t before_ticks = walk->exact_ticks;
    uint32_t ticks = 0;

    walk->until--;
    // The very last step is at the end of the piece, whatever the decoder would say.
    if (walk->until != 0 || walk->last_special != walk->count) {
        ticks =
            walk->curved ? curve_next(&walk->steps.curve) : even_next(&walk->steps.even);
        walk->exact_ticks = before_ticks + ticks;
    }
    if (walk->until != 0) {
        walk->at_edge = false;
        return ticks;
    }
    return special(walk, before_ticks);
}

uint32_t walk_skip_even(struct walk *walk, uint16_t steps)
{
    uint32_t ticks = even_skip(&walk->steps.even, steps);

    walk->until = (uint16_t)(walk->until - steps);
    walk->exact_ticks += ticks;
    walk->at_edge = walk->until == 0 && walk->edge_steps == walk->count;
    return ticks;
}
