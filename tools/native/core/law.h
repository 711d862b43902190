// SPDX-License-Identifier: MIT
// The inner loops of the planner of motion programs, programs/time_law.py: how fast a path may be
// run. The unknown w = (du/dt)^2 is x at an interval's beginning and y at its end, and each bound j
// of an interval says |a[j] y - b[j] x| <= most[j % motors] with a[j] >= 0.
#pragma once

#include <stdint.h>

struct law {
    // Intervals; bounds of each, a multiple of the motors; motors.
    uint32_t count;
    uint32_t bounds;
    uint32_t motors;
    // Coefficients, one row of `bounds` an interval; limits, one row of `motors`.
    const double *a;
    const double *b;
    const double *most;
    // The highest x and y by anything else. In a rest w is free.
    const double *cap;
    const double *end_cap;
    const uint8_t *rest;
};

// Lower `cap` to the highest x with which some y satisfies all bounds of its interval.
void law_caps(const struct law *law, double *cap);

// Find the highest x of each interval from which all bounds can be kept up to the last one, whose y
// is at most `end`. Returns the x of the first one.
double law_backward(const struct law *law, double end, double *highest);

// Run the intervals as fast as they may be, from w on. `following` is the highest x of the interval
// behind the last one. Returns the w behind them.
double law_forward(const struct law *law,
                   const double *highest,
                   double following,
                   double w,
                   double *begin,
                   double *end);
