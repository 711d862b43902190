// SPDX-License-Identifier: MIT
// Where a curve is, in numbers that every way to go on from there begins with, and what such a way
// hands back.
#pragma once

#include <stdint.h>

#include "base/wide.h" // struct wide

struct curve_place {
    struct wide residual; // position beyond the last step in 1/T^2 steps
    struct wide slope;    // its increase over the next tick
    uint16_t step_low;    // T*T, the lower 16 bits,
    uint32_t step;        //   the upper 32
    int16_t half;         // half-acceleration h
};

// Steps made by one call; what is needed to publish them.
struct curve_made {
    uint32_t ticks;     // all intervals together
    uint8_t steps;      // 0: nothing else in this struct means anything
    uint8_t first_high; // high byte of the first entry: not yet stored
};

// The start of a piece of T ticks at speed v0.
void curve_place_start(struct curve_place *place,
                       uint32_t ticks,
                       uint16_t start_speed,
                       int16_t half);
