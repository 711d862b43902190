// SPDX-License-Identifier: MIT
#include "steps/walk.h"

#include "base/apart.h" // APART

#define NO_EDGE 0xFFFFu

static APART uint16_t edge_of(const struct piece *piece)
{
    return piece->has_edge ? piece->edge_steps : NO_EDGE;
}

// Aim at the next special step behind step `index`. Special are the two steps around the pixel
// edge, the step after these two, whose interval makes up for their shift, and the piece's last
// step.
static void aim_at_special(struct walk *walk, uint16_t index)
{
    uint16_t next = walk->piece->steps;
    uint16_t edge = edge_of(walk->piece);

    if (edge != NO_EDGE) {
        for (uint8_t after = 0; after < 3; after++) {
            uint16_t candidate = (uint16_t)(edge + after);
            if (candidate > index && candidate < next) {
                next = candidate;
                break;
            }
        }
    }
    walk->last_special = next;
    walk->until = (uint16_t)(next - index);
}

APART void walk_start(struct walk *walk, const struct piece *piece)
{
    walk->curved = piece->curved;
    walk->at_edge = false;
    walk->exact_ticks = 0;
    walk->skew_ticks = 0;
    walk->piece = piece;
    aim_at_special(walk, 0);
    if (piece->curved) {
        curve_start(&walk->steps.curve, piece->ticks, piece->start_speed, piece->steps);
    } else {
        even_start(&walk->steps.even, piece->ticks, piece->steps);
    }
}

// The tick of special step `index`, counted from the start of the piece. Steps stay on their side
// of the pixel edge, and the last step falls on the end of the piece.
static uint32_t place_special(const struct walk *walk, uint16_t index)
{
    const struct piece *piece = walk->piece;
    uint16_t edge = edge_of(piece);
    uint32_t tick = walk->exact_ticks;

    if (index == piece->steps) {
        tick = piece->ticks;
    } else if (index == edge && tick > piece->edge_ticks) {
        tick = piece->edge_ticks;
    } else if (index == (uint16_t)(edge + 1u) && tick <= piece->edge_ticks) {
        tick = piece->edge_ticks + 1u;
    }
    return tick;
}

// Shift a special step to its tick.
static uint32_t shift_special(struct walk *walk, uint32_t ticks)
{
    uint16_t index = walk->last_special;
    uint32_t tick = place_special(walk, index);
    uint32_t skew = tick - walk->exact_ticks;
    uint32_t before = (uint32_t)walk->skew_ticks;

    ticks += skew - before;
    walk->at_edge = index == edge_of(walk->piece);
    if (index < walk->piece->steps) {
        // 16 bits hold the shift: rounding and the exact place of an edge are less than a tick
        // apart.
        walk->skew_ticks = (int16_t)skew;
        aim_at_special(walk, index);
    }
    return ticks;
}

uint32_t walk_next(struct walk *walk)
{
    BY_POINTER_SMALL(walk);
    uint32_t ticks = 0;

    walk->until--;
    // The very last step falls on the end of the piece; the decoder is not asked for it.
    if (walk->until != 0 || walk->last_special != walk->piece->steps) {
        ticks =
            walk->curved ? curve_next(&walk->steps.curve) : even_next(&walk->steps.even);
        walk->exact_ticks += ticks;
    }
    if (walk->until != 0) {
        walk->at_edge = false;
        return ticks;
    }
    return shift_special(walk, ticks);
}

void walk_pass_train(struct walk *walk, uint16_t steps, uint32_t ticks)
{
    BY_POINTER_SMALL(walk);
    walk->until = (uint16_t)(walk->until - steps);
    walk->exact_ticks += ticks;
    walk->at_edge = walk->until == 0 && edge_of(walk->piece) == walk->piece->steps;
}
