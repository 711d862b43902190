// SPDX-License-Identifier: MIT
// Walks through a piece step by step and keeps two promises at whole ticks: the last step falls
// exactly on the end of the piece, and a step lies at or before the piece's pixel edge in ticks
// if and only if it does in exact arithmetic.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "motion/curve.h" // struct curve
#include "motion/even.h"  // struct even
#include "motion/line.h"  // struct piece

struct walk {
    union {
        struct curve curve;
        struct even even;
    } steps;
    bool curved;
    bool at_edge;          // the step just returned is the last one before the pixel edge
    int16_t skew_ticks;    // where the last step was put, minus exact_ticks
    uint16_t until;        // steps to the next special one,
    uint16_t last_special; //   which is this one of the piece
    uint32_t exact_ticks;  // where the last step would fall without the promises
    const struct piece *piece;
};

// piece->steps must not be 0; the piece must stay as it is until the walk is over.
void walk_start(struct walk *walk, const struct piece *piece);

// Ticks from the last step (or the start of the piece) to the next. Call piece->steps times.
uint32_t walk_next(struct walk *walk);

// Steps that may be taken straight from walk->steps: none of them is special.
static inline uint16_t walk_burst(const struct walk *walk)
{
    return (uint16_t)(walk->until - 1u);
}

// Even pieces: steps up to the next place that needs care, the end of the piece included when that
// is where it lies.
static inline uint16_t walk_stretch(const struct walk *walk)
{
    bool to_end = walk->last_special == walk->piece->steps && walk->skew_ticks == 0;

    return to_end ? walk->until : walk_burst(walk);
}

// Steps of the piece taken so far, if nothing but its end needs care any more; else 0xFFFF.
static inline uint16_t walk_taken(const struct walk *walk)
{
    uint16_t steps = walk->piece->steps;

    return walk->last_special == steps ? (uint16_t)(steps - walk->until)
                                       : (uint16_t)0xFFFF;
}

// Pass over that many of these steps; the ticks to the last of them.
uint32_t walk_skip_even(struct walk *walk, uint16_t steps);

// `count` steps of together `ticks` were taken straight from walk->steps.
static inline void walk_skip(struct walk *walk, uint8_t count, uint32_t ticks)
{
    walk->until = (uint16_t)(walk->until - count);
    walk->exact_ticks += ticks;
}

// True when every step of the piece has been returned.
static inline bool walk_done(const struct walk *walk)
{
    return walk->until == 0;
}
