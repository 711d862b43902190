// SPDX-License-Identifier: MIT
#include "motion/curve.h"

#include <stdbool.h>

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
    uint32_t high = (uint32_t)a.high * factor + (low >> 8);

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

// An extrapolated interval d at speed v misses by 3 (aT)^2 / v^4 residual units; that must stay
// below 2^38, and with v = T / d it does up to d = 512 sqrt(T / a). Above speed * T = 2^37 three
// corrections would no longer fit 40 bits: no extrapolation there (over 8192 steps/s at 1 Hz).
static uint16_t fast_limit(uint32_t ticks, uint16_t acceleration, uint16_t top_speed)
{
    if (((uint64_t)top_speed * ticks) >> 37 != 0) {
        return 0;
    }
    uint32_t limit = acceleration == 0 ? 0x7FFFu : 512uL * root_u32(ticks / acceleration);

    return limit > 0x7FFFu ? 0x7FFFu : (uint16_t)limit;
}

void curve_start(struct curve *curve, uint32_t ticks, uint16_t start_speed, uint16_t steps)
{
    int16_t half = (int16_t)(steps - start_speed);
    uint16_t acceleration = (uint16_t)(2u * (uint16_t)(half < 0 ? -half : half));

    curve->half_acceleration = half;
    curve->step_exact = (uint64_t)ticks * ticks;
    curve->step = wide_from((int64_t)curve->step_exact);
    curve->residual = wide_from(0);
    curve->slope = wide_from((int64_t)((uint64_t)start_speed * ticks) + half);
    curve->fast_limit_ticks = fast_limit(ticks, acceleration,
                                         half < 0 ? start_speed : (uint16_t)((int16_t)steps + half));
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
    int64_t slope = wide_to(curve->slope);
    int32_t half = curve->half_acceleration;
    int64_t start = wide_to(curve->residual) - (int64_t)curve->step_exact;
    uint32_t ticks = at_least_one(curve->guess_ticks);

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
            curve->residual = wide_from(value);
            curve->slope = wide_from(difference + 2 * half);
            return ticks;
        }
    }
}

// Remember an interval for extrapolation; 0 stands for one that is too long for it.
static void remember(struct curve *curve, uint32_t ticks)
{
    curve->before_ticks = curve->last_ticks;
    curve->last_ticks = ticks <= curve->fast_limit_ticks ? (uint16_t)ticks : 0;
    curve->guess_ticks = ticks;
}

// The fast case: false (and nothing changed) when the guess is further off than a few ticks.
static bool extrapolate(struct curve *curve)
{
    uint16_t ticks = (uint16_t)(2u * curve->last_ticks - curve->before_ticks);

    if (curve->before_ticks == 0 || curve->last_ticks == 0 || ticks == 0 || ticks > 0x7FFFu) {
        return false;
    }
    int32_t bend = (int32_t)curve->half_acceleration * (int16_t)(ticks - 1u);
    struct wide bent = wide_from_int32(bend);
    struct wide sum = wide_add(curve->slope, bent);
    struct wide value = wide_sub(wide_add(curve->residual, wide_times(sum, ticks)), curve->step);
    struct wide difference = wide_add(sum, bent); // value(ticks) - value(ticks - 1)
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
    curve->residual = value;
    curve->slope = wide_add(difference, twice_half);
    curve->before_ticks = curve->last_ticks;
    curve->last_ticks = ticks <= curve->fast_limit_ticks ? ticks : 0;
    curve->guess_ticks = ticks;
    return true;
}

uint32_t curve_next(struct curve *curve)
{
    if (extrapolate(curve)) {
        return curve->guess_ticks;
    }
    uint32_t ticks = solve(curve);

    remember(curve, ticks);
    return ticks;
}
