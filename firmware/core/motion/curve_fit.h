// SPDX-License-Identifier: MIT
// The next step of a curve from a guess of its interval, modulo 2^32 (narrow) or 2^40 (wide): the
// value at the guess, then single ticks up or down until it is the smallest that reaches the step.
// For curve.c.
#pragma once

#include "base/multiply.h" // multiply_*
#include "motion/curve.h"

// Beyond this many single-tick corrections a division is cheaper.
#define CURVE_CORRECTIONS_MAX 3u

struct narrow_value {
    uint32_t value;      // residual after so many ticks
    uint32_t difference; // minus the value a tick before
};

struct wide_value {
    struct wide value;
    struct wide difference;
};

static inline struct narrow_value evaluate_narrow(const struct curve_narrow *state,
                                                  int16_t half,
                                                  uint16_t ticks)
{
    uint32_t bend = multiply_s16_s16(half, (int16_t)(ticks - 1u));
    uint32_t sum = (uint32_t)state->slope + bend;
    uint32_t value = multiply_u32_u16(sum, ticks);

    value += (uint32_t)state->residual;
    value -= state->step;
    return (struct narrow_value){.value = value, .difference = sum + bend};
}

static inline struct wide_value evaluate_wide(const struct curve_wide *state,
                                              int16_t half,
                                              uint16_t ticks)
{
    struct wide bend =
        wide_from_int32((int32_t)multiply_s16_s16(half, (int16_t)(ticks - 1u)));
    struct wide sum = wide_add(state->slope, bend);

    return (struct wide_value){
        .value = wide_sub(wide_add(state->residual, wide_times(sum, ticks)), state->step),
        .difference = wide_add(sum, bend),
    };
}

// The interval, and the state behind the step; 0 and nothing changed when the guess is further off
// than a few ticks. What counts as negative is the curve's, see struct curve_narrow.
static inline uint16_t fit_narrow(struct curve_narrow *state,
                                  int16_t half,
                                  uint16_t ticks)
{
    uint32_t twice_half = (uint32_t)(2 * (int32_t)half);
    struct narrow_value at = evaluate_narrow(state, half, ticks);

    for (uint8_t left = CURVE_CORRECTIONS_MAX; at.value >= state->negative_from; left--) {
        if (left == 0) {
            return 0;
        }
        at.difference += twice_half;
        at.value += at.difference;
        ticks++;
    }
    for (uint8_t left = CURVE_CORRECTIONS_MAX;
         (uint32_t)(at.value - at.difference) < state->negative_from;
         left--) {
        if (left == 0 || ticks == 1u) {
            return 0;
        }
        at.value -= at.difference;
        at.difference -= twice_half;
        ticks--;
    }
    state->residual = (int32_t)at.value;
    state->slope = (int32_t)(at.difference + twice_half);
    return ticks;
}

static inline uint16_t fit_wide(struct curve_wide *state, int16_t half, uint16_t ticks)
{
    struct wide twice_half = wide_from_int32(2 * (int32_t)half);
    struct wide_value at = evaluate_wide(state, half, ticks);

    for (uint8_t left = CURVE_CORRECTIONS_MAX; at.value.high < 0; left--) {
        if (left == 0) {
            return 0;
        }
        at.difference = wide_add(at.difference, twice_half);
        at.value = wide_add(at.value, at.difference);
        ticks++;
    }
    for (uint8_t left = CURVE_CORRECTIONS_MAX;; left--) {
        struct wide less = wide_sub(at.value, at.difference);
        if (less.high < 0) {
            break;
        }
        if (left == 0 || ticks == 1u) {
            return 0;
        }
        at.value = less;
        at.difference = wide_sub(at.difference, twice_half);
        ticks--;
    }
    state->residual = at.value;
    state->slope = wide_add(at.difference, twice_half);
    return ticks;
}
