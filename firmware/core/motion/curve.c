// SPDX-License-Identifier: MIT
#include "motion/curve.h"

#include <stdbool.h>

#include "base/multiply.h" // multiply_*

// Beyond this many single-tick corrections the exact path is cheaper.
#define CORRECTIONS_MAX 3u

static struct wide wide_from(int64_t value)
{
    return (struct wide){.high = (int32_t)(value >> 8), .low = (uint8_t)value};
}

static int64_t wide_to(struct wide value)
{
    return ((int64_t)value.high << 8) | value.low;
}

// Sums are taken modulo 2^40 on purpose, hence the unsigned detour.
static inline struct wide wide_add(struct wide a, struct wide b)
{
    uint16_t low = (uint16_t)((uint16_t)a.low + b.low);
    uint32_t high = (uint32_t)a.high + (uint32_t)b.high + (uint32_t)(low >> 8);

    return (struct wide){.high = (int32_t)high, .low = (uint8_t)low};
}

static inline struct wide wide_sub(struct wide a, struct wide b)
{
    uint32_t high = (uint32_t)a.high - (uint32_t)b.high - (a.low < b.low ? 1u : 0u);

    return (struct wide){.high = (int32_t)high, .low = (uint8_t)(a.low - b.low)};
}

static inline struct wide wide_from_int32(int32_t value)
{
    return (struct wide){.high = value >> 8, .low = (uint8_t)value};
}

static inline struct wide wide_times(struct wide a, uint16_t factor)
{
    uint32_t low = (uint32_t)a.low * factor;
    uint32_t high = multiply_u32_u16((uint32_t)a.high, factor) + (low >> 8);

    return (struct wide){.high = (int32_t)high, .low = (uint8_t)low};
}

// Largest r with r * r <= value.
static uint16_t root_u32(uint32_t value)
{
    uint16_t root = 0;

    for (uint16_t bit = 0x8000u; bit != 0; bit >>= 1) {
        uint16_t trial = (uint16_t)(root | bit);
        if ((uint32_t)trial * trial <= value) {
            root = trial;
        }
    }
    return root;
}

// An extrapolated interval d at speed v misses by 3 (aT)^2 / v^4 residual units. That must stay
// below half the modulus: with v = T / d it is below 2^38 up to d = 512 sqrt(T / a), below 2^30 up
// to d = 128 sqrt(T / a). Above speed * T = 2^37 three corrections would no longer fit 40 bits:
// no extrapolation there (over 8192 steps/s at 1 Hz).
static uint16_t fast_limit(uint32_t ticks, uint16_t acceleration, uint64_t top_slope)
{
    if (top_slope >> 37 != 0) {
        return 0;
    }
    uint32_t factor = top_slope >> 29 != 0 ? 512uL : 128uL;
    uint32_t limit = acceleration == 0 ? 0x7FFFu : factor * root_u32(ticks / acceleration);

    return limit > 0x7FFFu ? 0x7FFFu : (uint16_t)limit;
}

// The state behind the exact residual and slope.
static void set_state(struct curve *curve, int64_t residual, int64_t slope)
{
    if (curve->is_narrow) {
        curve->state.narrow.residual = (int32_t)residual;
        curve->state.narrow.slope = (int32_t)slope;
    } else {
        curve->state.wide.residual = wide_from(residual);
        curve->state.wide.slope = wide_from(slope);
    }
}

void curve_start(struct curve *curve, uint32_t ticks, uint16_t start_speed, uint16_t steps)
{
    int16_t half = (int16_t)(steps - start_speed);
    uint16_t acceleration = (uint16_t)(2u * (uint16_t)(half < 0 ? -half : half));
    uint16_t top_speed = half < 0 ? start_speed : (uint16_t)((int16_t)steps + half);
    uint64_t top_slope = (uint64_t)top_speed * ticks;
    uint64_t step = (uint64_t)ticks * ticks;

    curve->is_narrow = top_slope >> 29 == 0;
    curve->half_acceleration = half;
    curve->piece_ticks = ticks;
    if (curve->is_narrow) {
        curve->state.narrow.step = (uint32_t)step;
    } else {
        curve->state.wide.step = wide_from((int64_t)step);
    }
    set_state(curve, 0, (int64_t)((uint64_t)start_speed * ticks) + half);
    curve->fast_limit_ticks = fast_limit(ticks, acceleration, top_slope);
    curve->last_ticks = 0;
    curve->before_ticks = 0;
    // Speeding up, the root lies left of this guess, slowing down right of it: on both sides
    // Newton's method approaches it without crossing.
    curve->guess_ticks = start_speed == 0 ? ticks : ticks / start_speed;
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

// Exact interval by Newton's method from guess_ticks, and the state after it.
static uint32_t solve(struct curve *curve)
{
    int64_t slope = curve->is_narrow ? curve->state.narrow.slope : wide_to(curve->state.wide.slope);
    int64_t start =
        curve->is_narrow ? curve->state.narrow.residual : wide_to(curve->state.wide.residual);
    int32_t half = curve->half_acceleration;
    uint32_t ticks = at_least_one(curve->guess_ticks);

    start -= (int64_t)((uint64_t)curve->piece_ticks * curve->piece_ticks);
    for (;;) {
        int64_t bend = (int64_t)half * ((int32_t)ticks - 1);
        int64_t value = start + (int64_t)ticks * (slope + bend);
        int64_t difference = slope + 2 * bend; // value(ticks) - value(ticks - 1)

        if (value < 0) {
            difference += 2 * half;
            ticks += difference <= 0 ? 1u
                                     : at_least_one(quotient((uint64_t)-value, (uint64_t)difference));
        } else if (value >= difference && ticks > 1) {
            ticks -= at_least_one(quotient((uint64_t)value, (uint64_t)difference));
        } else {
            set_state(curve, value, difference + 2 * half);
            return ticks;
        }
    }
}

// The fast case modulo 2^32: false (and nothing changed) when the guess is further off than a few
// ticks. Sums wrap on purpose, hence unsigned.
static inline bool fit_narrow(struct curve *curve, uint16_t *interval)
{
    struct curve_narrow *state = &curve->state.narrow;
    uint16_t ticks = *interval;
    int16_t half = curve->half_acceleration;
    uint32_t bend = multiply_s16_s16(half, (int16_t)(ticks - 1u));
    uint32_t sum = (uint32_t)state->slope + bend;
    uint32_t value = (uint32_t)state->residual + multiply_u32_u16(sum, ticks) - state->step;
    uint32_t difference = sum + bend; // value(ticks) - value(ticks - 1)
    uint32_t twice_half = (uint32_t)(2 * (int32_t)half);

    for (uint8_t left = CORRECTIONS_MAX;; left--) {
        if ((int32_t)value < 0) {
            difference += twice_half;
            value += difference;
            ticks++;
        } else {
            uint32_t less = value - difference;
            if ((int32_t)less < 0 || ticks <= 1u) {
                break;
            }
            value = less;
            difference -= twice_half;
            ticks--;
        }
        if (left == 0) {
            return false;
        }
    }
    state->residual = (int32_t)value;
    state->slope = (int32_t)(difference + twice_half);
    *interval = ticks;
    return true;
}

// The same modulo 2^40.
static bool fit_wide(struct curve *curve, uint16_t *interval)
{
    struct curve_wide *state = &curve->state.wide;
    uint16_t ticks = *interval;
    struct wide bend =
        wide_from_int32((int32_t)multiply_s16_s16(curve->half_acceleration, (int16_t)(ticks - 1u)));
    struct wide sum = wide_add(state->slope, bend);
    struct wide value = wide_sub(wide_add(state->residual, wide_times(sum, ticks)), state->step);
    struct wide difference = wide_add(sum, bend);
    struct wide twice_half = wide_from_int32(2 * (int32_t)curve->half_acceleration);

    for (uint8_t left = CORRECTIONS_MAX;; left--) {
        if (value.high < 0) {
            difference = wide_add(difference, twice_half);
            value = wide_add(value, difference);
            ticks++;
        } else {
            struct wide less = wide_sub(value, difference);
            if (less.high < 0 || ticks <= 1u) {
                break;
            }
            value = less;
            difference = wide_sub(difference, twice_half);
            ticks--;
        }
        if (left == 0) {
            return false;
        }
    }
    state->residual = value;
    state->slope = wide_add(difference, twice_half);
    *interval = ticks;
    return true;
}

uint16_t curve_next_fast(struct curve *curve)
{
    uint16_t last = curve->last_ticks;
    uint16_t before = curve->before_ticks;
    uint16_t ticks = (uint16_t)(2u * last - before);

    if (before == 0 || last == 0 || ticks == 0 || ticks > 0x7FFFu
        || !(curve->is_narrow ? fit_narrow(curve, &ticks) : fit_wide(curve, &ticks))) {
        return 0;
    }
    curve->before_ticks = last;
    curve->last_ticks = ticks <= curve->fast_limit_ticks ? ticks : 0;
    return ticks;
}

uint32_t curve_next(struct curve *curve)
{
    uint16_t last = curve->last_ticks;
    uint32_t ticks = curve_next_fast(curve);

    if (ticks == 0) {
        if (last != 0) {
            curve->guess_ticks = last;
        }
        ticks = solve(curve);
        curve->before_ticks = last;
        curve->last_ticks = ticks <= curve->fast_limit_ticks ? (uint16_t)ticks : 0;
        curve->guess_ticks = ticks;
    }
    return ticks;
}
