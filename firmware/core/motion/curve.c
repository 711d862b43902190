// SPDX-License-Identifier: MIT
#include "motion/curve.h"

#include "base/divide.h"   // divide_u32_u16
#include "base/multiply.h" // multiply_*

// No interval of a curve that may have become flat differs by as much from the one before.
#define FLAT_CHANGE_MAX 6

// How a curve begins to be steep that was flat.
#define STEEPEN_CHANGE 2

// Out of the way of what goes on at every batch.
#define COLD __attribute__((noinline))

// A curve is flat for now if the interval changes by less than two ticks from step to step, that is
// if gain_growth / 2 < difference: then it is well below four ticks for a sixteenth as many steps as the
// interval has ticks. Below an eighth of a tick it is so for any batch.
static bool is_below(int32_t growth_high, int32_t slope_high)
{
    return (growth_high < 0 ? -growth_high : growth_high) < slope_high;
}

static uint16_t end_speed(uint16_t start_speed, uint16_t steps)
{
    return (uint16_t)(2u * steps - start_speed);
}

void curve_start(struct curve *curve,
                 uint32_t ticks,
                 uint16_t start_speed,
                 uint16_t steps)
{
    uint16_t end = end_speed(start_speed, steps);
    struct curve_place at;

    curve_place_start(&at, ticks, start_speed, (int16_t)(steps - start_speed));
    curve->kind = CURVE_FLAT_NOT;
    if (at.half != 0) {
        curve->kind = (uint8_t)curve_flat_kind(ticks, start_speed, end, &curve->stays);
    }
    if (curve->kind == CURVE_FLAT_NOT) {
        curve_steep_start(&curve->state.steep, &at, ticks, start_speed);
        if (at.half > 0) {
            curve->state.steep.end_kind = (uint8_t)curve_flat_now(ticks, end);
        }
    } else {
        curve->state.flat.ticks = ticks;
        curve_flat_enter(
            &curve->state.flat.flat, &at, divide_u32_u16(ticks, start_speed));
    }
}

// Has a curve that speeds up become flat? Below three ticks it may: the change only shrinks.
static COLD void curve_flatten(struct curve *curve)
{
    struct curve_place at = curve->state.steep.at;
    uint16_t ticks = (uint16_t)curve->state.steep.last_ticks;
    uint8_t kind = curve->state.steep.end_kind;
    // Both without their lowest 8 bits.
    uint32_t half_slope_growth = multiply_u32_u16((uint16_t)at.half, ticks) >> 8;
    uint32_t half_gain_growth = multiply_u32_u16(half_slope_growth, ticks);
    uint32_t slope = (uint32_t)at.slope.high;

    if (kind != CURVE_FLAT_NOT && half_gain_growth < slope + slope / 2u) {
        curve->kind = kind;
        curve->stays = true;
        curve_flat_enter(&curve->state.flat.flat, &at, ticks);
    }
}

// A curve that slows down is no longer flat.
static COLD void curve_steepen(struct curve *curve)
{
    uint16_t last_ticks = (uint16_t)(curve->state.flat.flat.top + 1u);
    struct curve_place at;

    curve_place_start(&at, curve->state.flat.ticks, 0, 0);
    curve_flat_leave(&curve->state.flat.flat, &at);
    curve->kind = CURVE_FLAT_NOT;
    curve_steep_enter(&curve->state.steep, &at, last_ticks, STEEPEN_CHANGE);
}

// Choose how to go on, and for how many steps of `count`.
static uint8_t choose_kind(struct curve *curve, uint8_t count)
{
    const struct curve_flat *flat = &curve->state.flat.flat;

    if (curve->kind == CURVE_FLAT_NOT) {
        if (curve->state.steep.change > -FLAT_CHANGE_MAX &&
            curve->state.steep.at.half > 0 && curve->state.steep.good) {
            curve_flatten(curve);
        }
    } else if (!curve->stays &&
               !is_below(flat->gain_growth.high / 2, flat->difference.high)) {
        curve_steepen(curve);
    } else if (!curve->stays &&
               !is_below(flat->gain_growth.high, flat->difference.high / 8)) {
        uint16_t most = (uint16_t)(flat->top / 16u + 1u);
        if (most < count) {
            return (uint8_t)most;
        }
    }
    return count;
}

uint32_t curve_next(struct curve *curve)
{
    (void)choose_kind(curve, 1);
    if (curve->kind == CURVE_FLAT_NOT) {
        return curve_steep_next(&curve->state.steep);
    }
    return curve_flat_next(&curve->state.flat.flat, curve->kind == CURVE_FLAT_NARROW);
}

void curve_burst(struct curve *curve,
                 struct step_ring *ring,
                 uint8_t slot,
                 uint8_t count,
                 struct curve_made *made)
{
    count = choose_kind(curve, count);
    if (curve->kind == CURVE_FLAT_NOT) {
        curve_steep_burst(&curve->state.steep, ring, slot, count, made);
    } else {
        curve_flat_burst(&curve->state.flat.flat,
                         curve->kind == CURVE_FLAT_NARROW,
                         ring,
                         slot,
                         count,
                         made);
    }
}
