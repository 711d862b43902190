// SPDX-License-Identifier: MIT
// The steps of a curve: extrapolated and corrected as long as that is good, else exact.
#include "motion/curve.h"

#include "motion/curve_exact.h"
#include "motion/curve_fit.h"
#include "motion/step_ring.h" // struct step_ring

// After so many divisions the exact path is cheaper.
#define MENDS_MAX 2u

// Out of the way of the loops that keep everything in registers.
#define COLD __attribute__((noinline))

// A guess further off is mended by the quotient of value and difference. 0 when that leads nowhere.
static uint16_t mend(uint16_t ticks, int32_t value, int32_t difference)
{
    if (difference <= 0) {
        return 0;
    }
    int32_t wanted = (int32_t)ticks - value / difference;

    return wanted < 1 || wanted > 0x7FFF ? 0 : (uint16_t)wanted;
}

static COLD uint16_t mended(const struct curve *curve, uint16_t ticks)
{
    int16_t half = curve->half_acceleration;

    if (curve->is_narrow) {
        struct narrow_value at = evaluate_narrow(&curve->state.narrow, half, ticks);
        return mend(ticks, (int32_t)at.value, (int32_t)at.difference);
    }
    struct wide_value at = evaluate_wide(&curve->state.wide, half, ticks);
    return mend(ticks, at.value.high, at.difference.high);
}

// The next interval, from the last two. 0: nothing to extrapolate from, or no sense in it.
static inline uint16_t extrapolate(const struct curve *curve)
{
    uint16_t last = curve->last_ticks;
    uint16_t ticks = (uint16_t)(2u * last - curve->before_ticks);

    return last == 0 || curve->before_ticks == 0 || ticks > 0x7FFFu ? 0 : ticks;
}

static void remember(struct curve *curve, uint16_t ticks)
{
    curve->before_ticks = curve->last_ticks;
    curve->last_ticks = ticks <= curve->fast_limit_ticks ? ticks : 0;
}

static COLD uint16_t fit(struct curve *curve, uint16_t ticks)
{
    int16_t half = curve->half_acceleration;

    return curve->is_narrow ? fit_narrow(&curve->state.narrow, half, ticks)
                            : fit_wide(&curve->state.wide, half, ticks);
}

// One extrapolated step; 0 when it cannot be, and nothing has changed.
static COLD uint16_t next_extrapolated(struct curve *curve)
{
    uint16_t guess = extrapolate(curve);

    for (uint8_t left = MENDS_MAX; guess != 0; left--) {
        uint16_t ticks = fit(curve, guess);
        if (ticks != 0) {
            remember(curve, ticks);
            return ticks;
        }
        guess = left == 0 ? 0 : mended(curve, guess);
    }
    return 0;
}

void curve_burst(struct curve *curve,
                 struct step_ring *ring,
                 uint8_t slot,
                 uint8_t count,
                 struct curve_made *made)
{
    if (curve->is_flat) {
        curve_flat_burst(&curve->state.flat, curve->is_narrow, ring, slot, count, made);
        return;
    }
    *made = (struct curve_made){.steps = 0};
    while (made->steps != count) {
        uint16_t ticks = next_extrapolated(curve);
        if (ticks == 0) {
            break;
        }
        uint16_t top = (uint16_t)(ticks - 1u);
        ring->low[slot] = (uint8_t)top;
        if (made->steps == 0) {
            made->first_high = (uint8_t)(top >> 8);
        } else {
            ring->high[slot] = (uint8_t)(top >> 8);
        }
        slot++;
        made->ticks += ticks;
        made->steps++;
    }
}

// Where Newton's method starts: extrapolated, when there is something to extrapolate from.
static uint32_t newton_guess(const struct curve *curve)
{
    uint32_t guess = 2u * curve->guess_ticks - curve->older_ticks;

    if (curve->older_ticks == 0 || guess == 0 || guess > curve->piece_ticks) {
        return curve->guess_ticks;
    }
    return guess;
}

uint32_t curve_next(struct curve *curve)
{
    if (curve->is_flat) {
        return curve_flat_next(&curve->state.flat, curve->is_narrow);
    }
    uint16_t last = curve->last_ticks;
    uint32_t ticks = next_extrapolated(curve);

    if (ticks == 0) {
        if (last != 0) {
            curve->guess_ticks = last;
            curve->older_ticks = curve->before_ticks;
        }
        ticks = curve_exact_next(curve, newton_guess(curve));
        curve->before_ticks = last;
        curve->last_ticks = ticks <= curve->fast_limit_ticks ? (uint16_t)ticks : 0;
        curve->older_ticks = curve->first_solved ? curve->guess_ticks : 0;
        curve->guess_ticks = ticks;
        curve->first_solved = true;
    }
    return ticks;
}
