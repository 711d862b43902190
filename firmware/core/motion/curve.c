// SPDX-License-Identifier: MIT
#include "motion/curve.h"

#include <stdbool.h>

#include "base/multiply.h" // multiply_*

// Beyond this many single-tick corrections a division is cheaper; after so many divisions the exact
// path.
#define CORRECTIONS_MAX 3u
#define APPROACHES_MAX 2u

#define COLD __attribute__((noinline))

// Modulo 2^32 a guess may miss by four ticks of this slope,
#define NARROW_SLOPE_MAX 0x20000000uL
// and by two of this one when values from 0xA0000000 on are taken as negative.
#define FLAT_SLOPE_MAX 850000000uL

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
static uint16_t fast_limit(uint32_t ticks, uint16_t acceleration, uint64_t slope, bool narrow)
{
    if (slope >> 37 != 0) {
        return 0;
    }
    uint32_t factor = narrow ? 128uL : 512uL;
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

// An interval taken as unchanged misses by a * d^2 residual units. Where that is small enough, the
// interval at start speed stands for the two that extrapolation needs.
static void start_extrapolation(struct curve *curve, uint16_t acceleration)
{
    uint32_t limit = curve->is_narrow ? root_u32(0x40000000uL / (acceleration | 1u))
                                      : 512uL * root_u32(0x00100000uL / (acceleration | 1u));
    bool good = curve->guess_ticks <= limit && curve->guess_ticks <= curve->fast_limit_ticks;

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

// From step to step the interval changes by a*T/v^3 ticks. Below one that is less than the rounding
// to whole ticks, and repeating the last interval misses less than extending the change.
static bool is_flat(uint32_t ticks, uint16_t start_speed, uint16_t steps)
{
    uint16_t end = end_speed(start_speed, steps);
    uint16_t low = end < start_speed ? end : start_speed;
    uint16_t acceleration = end < start_speed ? (uint16_t)(start_speed - end)
                                              : (uint16_t)(end - start_speed);

    return (uint64_t)acceleration * ticks < (uint64_t)low * low * low;
}

bool curve_is_wide(uint32_t ticks, uint16_t start_speed, uint16_t steps)
{
    uint64_t slope = top_slope(ticks, start_speed, steps);

    return slope >= NARROW_SLOPE_MAX
           && (slope >= FLAT_SLOPE_MAX || !is_flat(ticks, start_speed, steps));
}

void curve_start(struct curve *curve, uint32_t ticks, uint16_t start_speed, uint16_t steps)
{
    int16_t half = (int16_t)(steps - start_speed);
    uint16_t acceleration = (uint16_t)(2u * (uint16_t)(half < 0 ? -half : half));
    uint64_t step = (uint64_t)ticks * ticks;

    curve->half_acceleration = half;
    curve->piece_ticks = ticks;
    curve->is_flat = is_flat(ticks, start_speed, steps);
    curve->is_narrow = !curve_is_wide(ticks, start_speed, steps);
    if (curve->is_narrow) {
        curve->state.narrow.step = (uint32_t)step;
        curve->state.narrow.negative_from = curve->is_flat ? 0xA0000000uL : 0x80000000uL;
    } else {
        curve->state.wide.step = wide_from((int64_t)step);
    }
    set_state(curve, 0, (int64_t)((uint64_t)start_speed * ticks) + half);
    curve->fast_limit_ticks = fast_limit(ticks, acceleration, top_slope(ticks, start_speed, steps), curve->is_narrow);
    // Speeding up, the root lies left of this guess, slowing down right of it: on both sides
    // Newton's method approaches it without crossing.
    curve->guess_ticks = start_speed == 0 ? ticks : ticks / start_speed;
    curve->older_ticks = 0;
    curve->first_solved = false;
    start_extrapolation(curve, acceleration);
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

// Exact interval by Newton's method, and the state after it.
static COLD uint32_t solve(struct curve *curve, uint32_t guess_ticks)
{
    int64_t slope = curve->is_narrow ? curve->state.narrow.slope : wide_to(curve->state.wide.slope);
    int64_t start =
        curve->is_narrow ? curve->state.narrow.residual : wide_to(curve->state.wide.residual);
    int32_t half = curve->half_acceleration;
    uint32_t ticks = at_least_one(guess_ticks);

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

// The fast case modulo 2^32. Sums wrap on purpose, hence unsigned; what counts as negative is the
// curve's (see curve_narrow).
struct narrow_fit {
    uint32_t value;      // residual after `ticks`
    uint32_t difference; // value(ticks) - value(ticks - 1)
    uint16_t ticks;
};

static inline void evaluate_narrow(const struct curve *curve, struct narrow_fit *fit)
{
    const struct curve_narrow *state = &curve->state.narrow;
    uint32_t bend = multiply_s16_s16(curve->half_acceleration, (int16_t)(fit->ticks - 1u));
    uint32_t sum = (uint32_t)state->slope + bend;

    fit->value = (uint32_t)state->residual + multiply_u32_u16(sum, fit->ticks) - state->step;
    fit->difference = sum + bend;
}

// Correct by single ticks; false when the guess is further off than a few.
static inline bool settle_narrow(struct narrow_fit *fit, uint32_t twice_half,
                                 uint32_t negative_from)
{
    for (uint8_t left = CORRECTIONS_MAX;; left--) {
        if (fit->value >= negative_from) {
            fit->difference += twice_half;
            fit->value += fit->difference;
            fit->ticks++;
        } else {
            uint32_t less = fit->value - fit->difference;
            if (less >= negative_from || fit->ticks <= 1u) {
                return true;
            }
            fit->value = less;
            fit->difference -= twice_half;
            fit->ticks--;
        }
        if (left == 0) {
            return false;
        }
    }
}

// Further off: by the quotient. False when that leads nowhere.
static bool approach(uint16_t *ticks, int32_t value, int32_t difference)
{
    if (difference <= 0) {
        return false;
    }
    int32_t wanted = (int32_t)*ticks - value / difference;

    if (wanted < 1 || wanted > 0x7FFF) {
        return false;
    }
    *ticks = (uint16_t)wanted;
    return true;
}

// Returns the interval, 0 when the guess cannot be mended and nothing has changed.
static COLD uint16_t fit_narrow_far(struct curve *curve, uint16_t guess)
{
    uint32_t twice_half = (uint32_t)(2 * (int32_t)curve->half_acceleration);
    struct narrow_fit fit = {.ticks = guess};

    evaluate_narrow(curve, &fit);
    for (uint8_t left = APPROACHES_MAX; !settle_narrow(&fit, twice_half, curve->state.narrow.negative_from); left--) {
        if (left == 0 || !approach(&fit.ticks, (int32_t)fit.value, (int32_t)fit.difference)) {
            return 0;
        }
        evaluate_narrow(curve, &fit);
    }
    curve->state.narrow.residual = (int32_t)fit.value;
    curve->state.narrow.slope = (int32_t)(fit.difference + twice_half);
    return fit.ticks;
}

// The ordinary step: right at once or after a tick of correction. `state` is the caller's copy of
// the curve's, so that a batch of steps keeps it in registers; 0: further off, state unchanged.
static inline uint16_t fit_narrow(struct curve_narrow *state, int16_t half, uint16_t ticks)
{
    uint32_t twice_half = (uint32_t)(2 * (int32_t)half);
    uint32_t bend = multiply_s16_s16(half, (int16_t)(ticks - 1u));
    uint32_t difference = (uint32_t)state->slope + bend;
    uint32_t value = multiply_u32_u16(difference, ticks);

    value += (uint32_t)state->residual;
    value -= state->step;
    difference += bend;
    for (uint8_t left = CORRECTIONS_MAX; value >= state->negative_from; left--) {
        if (left == 0) {
            return 0;
        }
        difference += twice_half;
        value += difference;
        ticks++;
    }
    for (uint8_t left = CORRECTIONS_MAX; (uint32_t)(value - difference) < state->negative_from; left--) {
        if (left == 0 || ticks == 1u) {
            return 0;
        }
        value -= difference;
        difference -= twice_half;
        ticks--;
    }
    state->residual = (int32_t)value;
    state->slope = (int32_t)(difference + twice_half);
    return ticks;
}

// The same modulo 2^40.
struct wide_fit {
    struct wide value;
    struct wide difference;
    uint16_t ticks;
};

static void evaluate_wide(const struct curve *curve, struct wide_fit *fit)
{
    const struct curve_wide *state = &curve->state.wide;
    struct wide bend = wide_from_int32(
        (int32_t)multiply_s16_s16(curve->half_acceleration, (int16_t)(fit->ticks - 1u)));
    struct wide sum = wide_add(state->slope, bend);

    fit->value = wide_sub(wide_add(state->residual, wide_times(sum, fit->ticks)), state->step);
    fit->difference = wide_add(sum, bend);
}

static bool settle_wide(struct wide_fit *fit, struct wide twice_half)
{
    for (uint8_t left = CORRECTIONS_MAX;; left--) {
        if (fit->value.high < 0) {
            fit->difference = wide_add(fit->difference, twice_half);
            fit->value = wide_add(fit->value, fit->difference);
            fit->ticks++;
        } else {
            struct wide less = wide_sub(fit->value, fit->difference);
            if (less.high < 0 || fit->ticks <= 1u) {
                return true;
            }
            fit->value = less;
            fit->difference = wide_sub(fit->difference, twice_half);
            fit->ticks--;
        }
        if (left == 0) {
            return false;
        }
    }
}

static COLD uint16_t fit_wide(struct curve *curve, uint16_t guess)
{
    struct wide twice_half = wide_from_int32(2 * (int32_t)curve->half_acceleration);
    struct wide_fit fit = {.ticks = guess};

    evaluate_wide(curve, &fit);
    for (uint8_t left = APPROACHES_MAX; !settle_wide(&fit, twice_half); left--) {
        if (left == 0 || !approach(&fit.ticks, fit.value.high, fit.difference.high)) {
            return 0;
        }
        evaluate_wide(curve, &fit);
    }
    curve->state.wide.residual = fit.value;
    curve->state.wide.slope = wide_add(fit.difference, twice_half);
    return fit.ticks;
}

// The next interval, from the last two. 0: nothing to extrapolate from, or no sense in it.
static inline uint16_t extrapolate(const struct curve *curve)
{
    uint16_t last = curve->last_ticks;
    uint16_t ticks = (uint16_t)(2u * last - curve->before_ticks);

    if (curve->is_flat) {
        return last;
    }
    return last == 0 || curve->before_ticks == 0 || ticks > 0x7FFFu ? 0 : ticks;
}

static void remember(struct curve *curve, uint16_t ticks)
{
    curve->before_ticks = curve->last_ticks;
    curve->last_ticks = ticks <= curve->fast_limit_ticks ? ticks : 0;
}

// One extrapolated step; 0 when it cannot be, and nothing has changed.
static COLD uint16_t next_extrapolated(struct curve *curve)
{
    uint16_t ticks = extrapolate(curve);

    if (ticks != 0) {
        ticks = curve->is_narrow ? fit_narrow_far(curve, ticks) : fit_wide(curve, ticks);
    }
    if (ticks != 0) {
        remember(curve, ticks);
    }
    return ticks;
}

// Ordinary steps of a narrow curve, up to the first that is not.
static uint8_t batch_narrow(struct curve *curve, uint16_t *intervals, uint8_t count)
{
    struct curve_narrow state = curve->state.narrow;
    int16_t half = curve->half_acceleration;
    uint8_t made = 0;

    for (; made != count; made++) {
        uint16_t ticks = extrapolate(curve);
        if (ticks == 0) {
            break;
        }
        ticks = fit_narrow(&state, half, ticks);
        if (ticks == 0) {
            break;
        }
        remember(curve, ticks);
        intervals[made] = ticks;
    }
    curve->state.narrow = state;
    return made;
}

uint8_t curve_batch(struct curve *curve, uint16_t *intervals, uint8_t count)
{
    uint8_t made = 0;

    while (made != count) {
        if (curve->is_narrow) {
            made = (uint8_t)(made + batch_narrow(curve, &intervals[made], (uint8_t)(count - made)));
            if (made == count) {
                break;
            }
        }
        uint16_t ticks = next_extrapolated(curve);
        if (ticks == 0) {
            break;
        }
        intervals[made] = ticks;
        made++;
    }
    return made;
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
    uint16_t last = curve->last_ticks;
    uint32_t ticks = next_extrapolated(curve);

    if (ticks == 0) {
        if (last != 0) {
            curve->guess_ticks = last;
            curve->older_ticks = curve->before_ticks;
        }
        ticks = solve(curve, newton_guess(curve));
        curve->before_ticks = last;
        curve->last_ticks = ticks <= curve->fast_limit_ticks ? (uint16_t)ticks : 0;
        curve->older_ticks = curve->first_solved ? curve->guess_ticks : 0;
        curve->guess_ticks = ticks;
        curve->first_solved = true;
    }
    return ticks;
}
