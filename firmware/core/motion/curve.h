// SPDX-License-Identifier: MIT
// Steps under constant acceleration inside one piece of T ticks: start speed v0 (steps a piece),
// n steps, half-acceleration h = n - v0. Step k falls at the smallest whole tick t with
//
//     v0*T*t + h*t*t >= k*T*T                                   (spec 1.5, in integers)
//
// How far a step lies beyond that is a small number, the residual: kept exactly, it tells each
// interval from the last without roots or divisions, by additions where the interval hardly changes
// (curve_flat.h), by a guess and its correction elsewhere (curve_steep.h).
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "motion/curve_flat.h"  // struct curve_flat, struct curve_made
#include "motion/curve_steep.h" // struct curve_steep

// A curve may become flat as it speeds up, and steep as it slows down.
struct curve {
    union {
        struct {
            struct curve_flat flat;
            uint32_t ticks; // T
        } flat;
        struct curve_steep steep;
    } state;
    uint8_t kind; // enum curve_flat_kind
    bool stays;   // flat to its end
};

// ticks T: 1024..2^24-1; start speed v0 and end speed 2n - v0: 0..32767. For the main loop only: it
// divides.
void curve_start(struct curve *curve,
                 uint32_t ticks,
                 uint16_t start_speed,
                 uint16_t steps);

// Ticks to the next step. For steps 1..n-1; the caller forces step n to the end of the piece.
uint32_t curve_next(struct curve *curve);

// Up to `count` steps into the ring's slots from `slot` on, as long as that goes fast (none:
// curve_next() must make the next one). Each slot gets both bytes of interval - 1, but the high
// byte of the first is only reported: storing it is what publishes them all.
void curve_burst(struct curve *curve,
                 struct step_ring *ring,
                 uint8_t slot,
                 uint8_t count,
                 struct curve_made *made);
