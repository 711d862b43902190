// SPDX-License-Identifier: MIT
// Where a curve is, in numbers that every way to go on from there begins with.
#pragma once

#include <stdint.h>

#include "base/wide.h" // struct wide

struct curve_place {
    struct wide residual; // position beyond the last step in 1/T^2 steps
    struct wide slope;    // its increase over the next tick
    uint32_t step;        // T*T, the lower 32 bits,
    uint16_t step_high;   //   the upper 16
    int16_t half;         // half-acceleration h
};

// The start of a piece of T ticks at speed v0.
void curve_place_start(struct curve_place *place,
                       uint32_t ticks,
                       uint16_t start_speed,
                       int16_t half);
