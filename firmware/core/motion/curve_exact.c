// SPDX-License-Identifier: MIT
#include "motion/curve_exact.h"

void curve_exact_set(struct curve *curve, int64_t residual, int64_t slope)
{
    if (curve->is_narrow) {
        curve->state.narrow.residual = (int32_t)residual;
        curve->state.narrow.slope = (int32_t)slope;
    } else {
        curve->state.wide.residual = wide_from(residual);
        curve->state.wide.slope = wide_from(slope);
    }
}

// numerator / denominator, both positive, rounded down or a little lower.
static uint32_t quotient(uint64_t numerator, uint64_t denominator)
{
    while ((numerator >> 32) != 0) {
        numerator >>= 8;
        denominator = (denominator >> 8) + 1u;
    }
    return (denominator >> 32) != 0 ? 0 : (uint32_t)numerator / (uint32_t)denominator;
}

static uint32_t at_least_one(uint32_t ticks)
{
    return ticks == 0 ? 1u : ticks;
}

uint32_t curve_exact_next(struct curve *curve, uint32_t guess_ticks)
{
    int64_t slope =
        curve->is_narrow ? curve->state.narrow.slope : wide_to(curve->state.wide.slope);
    int64_t start = curve->is_narrow ? curve->state.narrow.residual
                                     : wide_to(curve->state.wide.residual);
    int32_t half = curve->half_acceleration;
    int32_t twice_half = 2 * half;
    uint32_t ticks = at_least_one(guess_ticks);

    start -= (int64_t)((uint64_t)curve->piece_ticks * curve->piece_ticks);
    for (;;) {
        int64_t bend = (int64_t)half * ((int32_t)ticks - 1);
        int64_t value = start + (int64_t)ticks * (slope + bend);
        int64_t difference = slope + 2 * bend; // value(ticks) - value(ticks - 1)

        if (value < 0) {
            difference += twice_half;
            ticks += difference <= 0
                         ? 1u
                         : at_least_one(quotient((uint64_t)-value, (uint64_t)difference));
        } else if (value >= difference && ticks > 1) {
            ticks -= at_least_one(quotient((uint64_t)value, (uint64_t)difference));
        } else {
            curve_exact_set(curve, value, difference + twice_half);
            return ticks;
        }
    }
}
