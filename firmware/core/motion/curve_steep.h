// SPDX-License-Identifier: MIT
// Where the interval changes by more than a few ticks from step to step. For curve.c.
//
// From step k to k + 1 with interval d the residual becomes
//
//     residual + d*(slope + h*(d-1)) - T*T                      slope = v0*T + h*(2t+1)
//
// which is 0 <= residual < last difference for exactly one d. A guess is evaluated modulo 2^48 (the
// residual itself fits 40 bits) and corrected by single ticks.
//
// Guesses: extrapolated from the last two intervals. While that is good to a few ticks, batches
// correct it by single ticks and 40 bits are enough; else it is improved by Newton's method.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "motion/curve_place.h" // struct curve_place, struct curve_made

struct step_ring;

struct curve_steep {
    struct curve_place at;
    uint32_t last_ticks; // last interval,
    int32_t change;      //   from the one before it
    uint8_t seen;        // of both: 0: last_ticks is a guess, 1: change is not known
    bool good;           // extrapolation will do for the next step
    uint8_t tops[3];     // a batch: sum of its entries,
    uint8_t first_high;  //   high byte of the first
    uint8_t end_kind;    // enum curve_flat_kind at the end, if it speeds up
};

// At the start of a piece of T ticks and speed v0.
void curve_steep_start(struct curve_steep *steep,
                       const struct curve_place *at,
                       uint32_t ticks,
                       uint16_t start_speed);

// From a place behind some step. The next interval is `change` ticks longer than the last, about.
void curve_steep_enter(struct curve_steep *steep,
                       const struct curve_place *at,
                       uint16_t last_ticks,
                       int16_t change);

// Up to `count` steps (not 0) into the ring's slots from `slot` on, but for the high byte of the
// first, as long as extrapolation is good.
void curve_steep_burst(struct curve_steep *steep,
                       struct step_ring *ring,
                       uint8_t slot,
                       uint8_t count,
                       struct curve_made *made);

// One step by whatever it takes.
uint32_t curve_steep_next(struct curve_steep *steep);
