// SPDX-License-Identifier: MIT
// For curve.c: the steps of a curve whose interval changes by more than a few ticks from step to
// step.
//
// From step k to k + 1 with interval d the residual becomes
//
//     residual + d*(slope + h*(d-1)) - T*T                      slope = v0*T + h*(2t+1)
//
// which is 0 <= residual < last difference for exactly one d. A guess of d is evaluated modulo 2^48
// (the residual itself fits 40 bits) and corrected by single ticks.
//
// The guess is extrapolated from the last two intervals. While the extrapolation is good to a few
// ticks, batches of steps correct it by single ticks, and 40 bits are enough; else Newton's method
// improves the guess. Main loop only.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "steps/curve_place.h" // struct curve_place, struct curve_made

struct step_ring;

// A batch of steps goes on while each guess misses by no more than this many ticks.
#define CURVE_STEEP_MISS_MAX 12
// A batch ends where the last difference comes to this many times 2^32.
#define CURVE_STEEP_LIMIT 0x15

// The functions below and curved_pixel.c write the members, and the assembly works on them. curve.c
// writes end_kind.
struct curve_steep {
    // The place after the last step.
    struct curve_place at;
    // The last interval, ticks, below 2^24.
    uint32_t last_ticks;
    // The last interval minus the one before it, ticks.
    int32_t change;
    // What is known of the two. 0: last_ticks is a guess; 1: `change` is not known; 2: both are
    // known, or were foreseen from the speed.
    uint8_t seen;
    // Extrapolation is good enough for the next step.
    bool good;
    // Of a batch: sum of its entries (intervals less 1), ticks, lowest byte first.
    uint8_t tops[3];
    // Of a batch: high byte of the first entry.
    uint8_t first_high;
    // enum curve_flat_kind at the end of a piece that speeds up; means nothing in other pieces.
    uint8_t end_kind;
};

// Begin a piece at *at. ticks: T. start_speed: steps a piece, 0..32767. Divides, and takes a root
// where the first interval cannot be foreseen from the speed.
void curve_steep_start(struct curve_steep *steep,
                       const struct curve_place *at,
                       uint32_t ticks,
                       uint16_t start_speed);

// Begin after some step of a piece, at *at. last_ticks: the last interval, ticks. The next interval
// is about `change` ticks longer than the last.
void curve_steep_enter(struct curve_steep *steep,
                       const struct curve_place *at,
                       uint16_t last_ticks,
                       int16_t change);

// Make up to `count` steps (not 0) into the ring's slots from `slot` on, as long as extrapolation
// is good. The high byte of the first slot is not stored: made->first_high returns it. made->steps
// is 0 where curve_steep_next() must make the next step.
void curve_steep_burst(struct curve_steep *steep,
                       struct step_ring *ring,
                       uint8_t slot,
                       uint8_t count,
                       struct curve_made *made);

// Make one step, with Newton's method where extrapolation is not good. Returns its interval, ticks.
uint32_t curve_steep_next(struct curve_steep *steep);
