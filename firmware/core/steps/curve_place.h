// SPDX-License-Identifier: MIT
// A place on a curve in the numbers with which every decoder of curves begins, and the result that
// every such decoder returns. For curve.c, curve_flat.c and curve_steep.c.
//
// All numbers are exact, because every place is a whole number of 1/T^2 steps. Main loop only.
//
//     unit          1/T^2 step
//     one step      T*T units            48 bits: step, step_low
//     one tick      adds slope units     40 bits; the next tick adds slope + 2h
#pragma once

#include <stdint.h>

#include "base/wide.h" // struct wide

struct curve_place {
    // Position beyond the last step, in units of 1/T^2 steps: 0 up to what the last tick added.
    struct wide residual;
    // Growth of the residual over the next tick, in the same units.
    struct wide slope;
    // Lower 16 bits of one step, which is T*T units.
    uint16_t step_low;
    // Upper 32 bits of one step.
    uint32_t step;
    // Half-acceleration h = n - v0, steps; negative where the curve slows down.
    int16_t half;
};

// Steps made by one call, and what the caller needs to publish them: the caller adds `ticks` to the
// time that is written and publishes the entries by storing first_high (stream_publish_batch()).
struct curve_made {
    // Sum of all intervals, ticks.
    uint32_t ticks;
    // Number of steps; 0: the other members mean nothing.
    uint8_t steps;
    // High byte of the first entry, which the caller stores last.
    uint8_t first_high;
};

// The start of a piece: step 0 lies exactly at tick 0, so that the residual is 0. ticks: T, below
// 2^24. start_speed: steps a piece, 0..32767. half: half-acceleration h, steps.
void curve_place_start(struct curve_place *place,
                       uint32_t ticks,
                       uint16_t start_speed,
                       int16_t half);
