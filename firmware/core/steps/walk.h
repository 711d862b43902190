// SPDX-License-Identifier: MIT
// Walks through a piece step by step and guarantees two things at whole ticks: the last step falls
// exactly on the end of the piece, and a step falls at or before the piece's pixel edge in ticks if
// and only if it does so in exact arithmetic. Main loop only.
//
// A step that needs care to keep these promises is called special: the last step before the edge,
// the two after the edge, and the last step of the piece.
//
//     piece       |------------------------ ticks -----------------------|
//     steps       |  1    2    3    4 ^  5    6    7    8    9    10   11|
//                                     edge_ticks, after edge_steps = 4
//     special                       4    5    6                        11
//     walk_burst()   1..3                          7..10
//
// Between special steps the decoder (axis/decode.c) takes steps straight from the walk's curve or
// even sequence and notes them with walk_skip(). One walk at a time for each axis.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "line/line.h"   // struct piece
#include "steps/curve.h" // struct curve
#include "stream/even.h" // struct even

// The functions below write all members but `steps`, which the decoder takes steps from. Between
// pieces decode.c uses `until` and `steps` for whole pixels.
struct walk {
    // `curved` says which member is valid.
    union {
        // The steps of a curved piece.
        struct curve curve;
        // The steps of an even piece.
        struct even even;
    } steps;
    // steps.curve is valid, else steps.even.
    bool curved;
    // The step just returned is the last one before the pixel edge.
    bool at_edge;
    // Where the last step was placed, minus exact_ticks, ticks; not 0 only beside a pixel edge.
    int16_t skew_ticks;
    // Steps up to and including the next special one; 0 when the walk is over.
    uint16_t until;
    // Number of that special step in the piece.
    uint16_t last_special;
    // Where the last step would fall without the two promises, ticks from the start of the piece.
    uint32_t exact_ticks;
    // The piece; the caller keeps it unchanged until the walk is over.
    const struct piece *piece;
};

// Begin a piece, whose `steps` must not be 0. The piece must stay as it is until the walk is over.
// Divides.
void walk_start(struct walk *walk, const struct piece *piece);

// Take one step. Returns the ticks from the last step, or from the start of the piece, to this one.
// To be called until walk_done(), piece->steps times if no steps are skipped.
uint32_t walk_next(struct walk *walk);

// Number of steps that may be taken straight from walk->steps, because none of them is special.
// Only while walk_done() is false.
static inline uint16_t walk_burst(const struct walk *walk)
{
    return (uint16_t)(walk->until - 1u);
}

// Of an even piece: number of steps that may be taken as a pulse train. The last step of the piece
// is included where it needs no correction.
static inline uint16_t walk_stretch(const struct walk *walk)
{
    bool to_end = walk->last_special == walk->piece->steps && walk->skew_ticks == 0;

    return to_end ? walk->until : walk_burst(walk);
}

// Steps of the piece taken so far, if only the end of the piece still needs care; else 0xFFFF.
static inline uint16_t walk_taken(const struct walk *walk)
{
    uint16_t steps = walk->piece->steps;

    return walk->last_special == steps ? (uint16_t)(steps - walk->until)
                                       : (uint16_t)0xFFFF;
}

// Note that `steps` steps, `ticks` long together, were taken straight from walk->steps.even; at
// most walk_stretch() of them. Tells whether the last of them lies at the pixel edge (at_edge).
void walk_pass_train(struct walk *walk, uint16_t steps, uint32_t ticks);

// Note that `count` steps, `ticks` long together, were taken straight from walk->steps; at most
// walk_burst().
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
