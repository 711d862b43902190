// SPDX-License-Identifier: MIT
// How a curve starts: which arithmetic it needs, and from where extrapolation can be trusted.
#include "motion/curve_exact.h"

// Modulo 2^32 a guess may miss by four ticks of this slope.
#define NARROW_SLOPE_MAX 0x20000000

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
static uint16_t fast_limit(uint32_t ticks,
                           uint16_t acceleration,
                           uint64_t slope,
                           bool narrow)
{
    if (slope >> 37 != 0) {
        return 0;
    }
    uint32_t factor = narrow ? 128uL : 512uL;
    uint32_t limit =
        acceleration == 0 ? 0x7FFFu : factor * root_u32(ticks / acceleration);

    return limit > 0x7FFFu ? 0x7FFFu : (uint16_t)limit;
}

// An interval taken as unchanged misses by a * d^2 residual units. Where that is small enough, the
// interval at start speed stands for the two that extrapolation needs.
static void start_extrapolation(struct curve *curve, uint16_t acceleration)
{
    uint32_t limit =
        curve->is_narrow
            ? root_u32((uint32_t)0x40000000u / (acceleration | 1u))
            : (uint32_t)512 * root_u32((uint32_t)0x00100000u / (acceleration | 1u));
    bool good =
        curve->guess_ticks <= limit && curve->guess_ticks <= curve->fast_limit_ticks;

    curve->last_ticks = good ? (uint16_t)curve->guess_ticks : 0;
    curve->before_ticks = curve->last_ticks;
}

static uint16_t end_speed(uint16_t start_speed, uint16_t steps)
{
    return (uint16_t)(2u * steps - start_speed);
}

static uint64_t top_slope(uint32_t ticks, uint16_t start_speed, uint16_t steps)
{
    uint16_t end = end_speed(start_speed, steps);

    return (uint64_t)(end > start_speed ? end : start_speed) * ticks;
}

bool curve_is_wide(uint32_t ticks, uint16_t start_speed, uint16_t steps)
{
    return top_slope(ticks, start_speed, steps) >= NARROW_SLOPE_MAX &&
           curve_flat_kind(ticks, start_speed, end_speed(start_speed, steps)) ==
               CURVE_FLAT_NOT;
}

void curve_start(struct curve *curve,
                 uint32_t ticks,
                 uint16_t start_speed,
                 uint16_t steps)
{
    int16_t half = (int16_t)(steps - start_speed);
    uint16_t acceleration = (uint16_t)(2u * (uint16_t)(half < 0 ? -half : half));
    uint64_t step = (uint64_t)ticks * ticks;

    enum curve_flat_kind kind =
        curve_flat_kind(ticks, start_speed, end_speed(start_speed, steps));
    if (kind != CURVE_FLAT_NOT) {
        curve->is_flat = true;
        curve->is_narrow = kind == CURVE_FLAT_NARROW;
        curve_flat_start(&curve->state.flat, ticks, start_speed, (int16_t)(2 * half));
        return;
    }
    curve->half_acceleration = half;
    curve->piece_ticks = ticks;
    curve->is_flat = false;
    curve->is_narrow = !curve_is_wide(ticks, start_speed, steps);
    if (curve->is_narrow) {
        curve->state.narrow.step = (uint32_t)step;
        curve->state.narrow.negative_from = 0x80000000uL;
    } else {
        curve->state.wide.step = wide_from((int64_t)step);
    }
    curve_exact_set(curve, 0, (int64_t)((uint64_t)start_speed * ticks) + half);
    curve->fast_limit_ticks = fast_limit(
        ticks, acceleration, top_slope(ticks, start_speed, steps), curve->is_narrow);
    // Speeding up, the root lies left of this guess, slowing down right of it: on both sides
    // Newton's method approaches it without crossing.
    curve->guess_ticks = start_speed == 0 ? ticks : ticks / start_speed;
    curve->older_ticks = 0;
    curve->first_solved = false;
    start_extrapolation(curve, acceleration);
}
