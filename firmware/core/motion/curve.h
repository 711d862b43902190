// SPDX-License-Identifier: MIT
// Steps under constant acceleration inside one piece of T ticks: start speed v0 (steps a piece),
// n steps, half-acceleration h = n - v0. Step k falls at the smallest whole tick t with
//
//     v0*T*t + h*t*t >= k*T*T                                   (spec 1.5, in integers)
//
// No square root and, in the fast case, no division: from step k to k+1 with interval d
//
//     residual' = residual + d*(slope + h*(d-1)) - T*T          slope = v0*T + h*(2t+1)
//
// is 0 <= residual' < last difference for exactly one d, found by extrapolating the last two
// intervals and correcting by single ticks (curve_fit.h). The residual is known to be small, so it
// is kept modulo 2^32 while speed * T < 2^29 (nearly 2^30 where the interval hardly changes), else
// modulo 2^40: exact while it is. Where extrapolation is poor (slow steps, the first two of a
// piece) Newton's method on the exact value takes over (curve_exact.h); those intervals are long
// enough to pay for it.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "base/wide.h"         // struct wide
#include "motion/curve_flat.h" // struct curve_flat, struct curve_made

// position beyond the last step in 1/T^2 steps; its increase over the next tick; T * T
struct curve_narrow {
    int32_t residual;
    int32_t slope;
    uint32_t step;          // modulo 2^32
    uint32_t negative_from; // values from here on stand for negative ones
};

struct curve_wide {
    struct wide residual;
    struct wide slope;
    struct wide step; // modulo 2^40
};

struct curve {
    union {
        struct curve_narrow narrow;
        struct curve_wide wide;
        struct curve_flat flat;
    } state;
    bool is_narrow;
    bool is_flat;
    int16_t half_acceleration;
    uint16_t last_ticks;   // last interval, 0: unknown or too long to extrapolate from
    uint16_t before_ticks; // the one before it
    uint16_t fast_limit_ticks; // intervals up to this one are safe in the modulus
    bool first_solved;
    uint32_t guess_ticks; // for Newton's method: the last interval,
    uint32_t older_ticks; //   and the one before it, 0: unknown
    uint32_t piece_ticks; // T
};

// Such a piece takes longest a step: it needs the 40-bit arithmetic and products. Arguments as for
// curve_start().
bool curve_is_wide(uint32_t ticks, uint16_t start_speed, uint16_t steps);

// ticks T: 1..2^24-1; start_speed v0 and end speed 2n - v0: 0..32767. Main loop only: it divides.
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
