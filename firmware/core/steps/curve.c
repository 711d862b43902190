// SPDX-License-Identifier: MIT
#include "steps/curve.h"

#include "base/apart.h"    // BY_POINTER_SMALL
#include "base/divide.h"   // divide_u32_u16
#include "base/multiply.h" // multiply_*

// As long as an interval is shorter than the last one by this much (ticks) or more, the curve
// cannot have become flat.
#define FLAT_CHANGE_MAX 6

// Change of the interval from step to step, ticks, with which a flat curve becomes steep.
#define STEEPEN_CHANGE 2

// For rare work: keep it out of the functions that every batch passes through.
#define COLD __attribute__((noinline))

// True when growth, whatever its sign, is below slope. A curve is flat for now if its interval
// changes by less than two ticks from step to step, that is if gain_growth / 2 < difference: the
// change then stays well below four ticks for a sixteenth as many steps as the interval has ticks.
// A change below an eighth of a tick stays below four ticks for a whole batch of any length.
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
            curve->state.steep.end_kind = (uint8_t)curve_flat_now(ticks, end, true);
        }
    } else {
        curve->state.flat.ticks = ticks;
        curve_flat_enter(
            &curve->state.flat.flat, &at, divide_u32_u16(ticks, start_speed));
    }
}

// Make a curve that speeds up flat once its interval changes by less than three ticks from step to
// step. The curve then stays flat, because the change only shrinks.
static COLD void curve_flatten(struct curve *curve)
{
    struct curve_place at = curve->state.steep.at;
    uint16_t ticks = (uint16_t)curve->state.steep.last_ticks;
    uint8_t kind = curve->state.steep.end_kind;
    // Both are without their lowest 8 bits.
    uint32_t half_slope_growth = multiply_u32_u16((uint16_t)at.half, ticks) >> 8;
    uint32_t half_gain_growth = multiply_u32_u16(half_slope_growth, ticks);
    uint32_t slope = (uint32_t)at.slope.high;

    if (kind != CURVE_FLAT_NOT && half_gain_growth < slope + slope / 2u) {
        curve->kind = kind;
        curve->stays = true;
        curve_flat_enter(&curve->state.flat.flat, &at, ticks);
    }
}

// Make a curve that slows down steep: its interval changes too much from step to step.
static COLD void curve_steepen(struct curve *curve)
{
    uint16_t last_ticks = (uint16_t)(curve->state.flat.flat.top + 1u);
    struct curve_place at;

    curve_place_start(&at, curve->state.flat.ticks, 0, 0);
    curve_flat_leave(&curve->state.flat.flat, &at);
    curve->kind = CURVE_FLAT_NOT;
    curve_steep_enter(&curve->state.steep, &at, last_ticks, STEEPEN_CHANGE);
}

// Choose the decoder of the next steps. Returns for how many of `count` steps the choice holds.
static uint8_t choose_kind(struct curve *curve, uint8_t count)
{
    const struct curve_flat *flat = &curve->state.flat.flat;

    if (curve->kind == CURVE_FLAT_NOT) {
        if (curve->state.steep.change > -FLAT_CHANGE_MAX &&
            curve->state.steep.at.half > 0 && curve->state.steep.good) {
            curve_flatten(curve);
        }
    } else if (!curve->stays &&
               !is_below(flat->gain_growth.high >> 1, flat->difference.high)) {
        curve_steepen(curve);
    } else if (!curve->stays &&
               !is_below(flat->gain_growth.high, flat->difference.high >> 3)) {
        uint16_t most = (uint16_t)(flat->top / 16u + 1u);
        if (most < count) {
            return (uint8_t)most;
        }
    }
    return count;
}

uint32_t curve_next(struct curve *curve)
{
    BY_POINTER_SMALL(curve);
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

uint8_t curve_narrow(struct curve *curve, uint8_t count)
{
    if (curve->kind != CURVE_FLAT_NARROW) {
        return 0;
    }
    if (!curve->stays) {
        count = choose_kind(curve, count);
    }
    return curve->kind == CURVE_FLAT_NARROW ? count : 0;
}
