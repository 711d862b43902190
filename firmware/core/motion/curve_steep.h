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
// Guesses: extrapolated from the last two intervals while that is good, else from the speeds at
// both ends of the interval, s = sqrt(v0*v0 + 4*h*k) behind step k, as d = 2T / (s + s'). The roots
// have 16 bits: the guess is some 2^-15 of itself off, which for a slow step is a few ticks.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "motion/curve_place.h" // struct curve_place

struct curve_steep {
    struct curve_place at;
    uint32_t scaled_ticks; // T, shifted left until its upper bit is bit 30,
    uint8_t ticks_scale;   //   by so much
    uint8_t root_scale;    // speed behind the last step, shifted left by so much,
    uint16_t root;         //   0: not known
    uint16_t start_speed;  // v0
    uint16_t steps;        // made so far
    uint16_t last_ticks;   // last interval, 0: longer than 15 bits
    uint16_t before_ticks; // the one before it
    bool good;             // extrapolation was good for the last step
};

// From a place behind so many steps of a piece of T ticks.
void curve_steep_enter(struct curve_steep *steep,
                       const struct curve_place *at,
                       uint32_t ticks,
                       uint16_t start_speed,
                       uint16_t steps);

// T
static inline uint32_t curve_steep_ticks(const struct curve_steep *steep)
{
    return steep->scaled_ticks >> steep->ticks_scale;
}

// One extrapolated step; 0 and nothing done when that is not good enough.
uint16_t curve_steep_quick(struct curve_steep *steep);

// One step by whatever it takes.
uint32_t curve_steep_next(struct curve_steep *steep);
