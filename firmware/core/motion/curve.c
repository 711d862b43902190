// SPDX-License-Identifier: MIT
#include "motion/curve.h"

#include "base/divide.h"      // divide_u32_u16
#include "base/multiply.h"    // multiply_*
#include "motion/step_ring.h" // struct step_ring

// Out of the way of what goes on at every batch.
#define COLD __attribute__((noinline))

// A curve is flat for now if the interval changes by less than two ticks from step to step, that is
// if bend / 2 < difference: then it is well below four ticks for a sixteenth as many steps as the
// interval has ticks. Below an eighth of a tick it is so for any batch.
static bool is_below(int32_t bend_high, int32_t slope_high)
{
    return (bend_high < 0 ? -bend_high : bend_high) < slope_high;
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
        curve_steep_enter(&curve->state.steep, &at, ticks, start_speed, 0);
    } else {
        curve->state.flat.ticks = ticks;
        curve->state.flat.start_speed = start_speed;
        curve->state.flat.steps = 0;
        curve_flat_enter(
            &curve->state.flat.flat, &at, divide_u32_u16(ticks, start_speed));
    }
}

// Has a curve that speeds up become flat? Below three ticks it may: the change only shrinks.
static COLD void flatten(struct curve *curve)
{
    struct curve_place at = curve->state.steep.at;
    uint16_t ticks = curve->state.steep.last_ticks;
    // Half the turn and the slope without their lowest 8 bits: bend itself may be too large.
    uint32_t half_turn = multiply_u32_u16((uint16_t)at.half, ticks) >> 8;
    struct wide half_bend = wide_times(wide_from_int32((int32_t)half_turn), ticks);
    struct wide slope = wide_from_int32(at.slope.high);

    if (wide_sub(half_bend, wide_add(slope, wide_from_int32(at.slope.high / 2))).high <
        0) {
        uint16_t top =
            (uint16_t)(curve->state.steep.start_speed + 2u * (uint16_t)at.half);
        uint8_t kind =
            (uint8_t)curve_flat_now(curve_steep_ticks(&curve->state.steep), top);
        if (kind != CURVE_FLAT_NOT) {
            curve->kind = kind;
            curve->stays = true;
            curve_flat_enter(&curve->state.flat.flat, &at, ticks);
        }
    }
}

// A curve that slows down is no longer flat.
static COLD void steepen(struct curve *curve)
{
    uint32_t ticks = curve->state.flat.ticks;
    uint16_t start_speed = curve->state.flat.start_speed;
    struct curve_place at;

    curve_place_start(&at, ticks, 0, 0);
    curve_flat_leave(&curve->state.flat.flat, &at);
    curve->kind = CURVE_FLAT_NOT;
    curve_steep_enter(
        &curve->state.steep, &at, ticks, start_speed, curve->state.flat.steps);
}

// Choose how to go on, and for how many steps of `count`.
static uint8_t settle(struct curve *curve, uint8_t count)
{
    const struct curve_flat *flat = &curve->state.flat.flat;

    if (curve->kind == CURVE_FLAT_NOT) {
        if (curve->state.steep.at.half > 0 && curve->state.steep.good) {
            flatten(curve);
        }
    } else if (!curve->stays && !is_below(flat->bend.high / 2, flat->difference.high)) {
        steepen(curve);
    } else if (!curve->stays && !is_below(flat->bend.high, flat->difference.high / 8)) {
        uint16_t most = (uint16_t)(flat->top / 16u + 1u);
        if (most < count) {
            return (uint8_t)most;
        }
    }
    return count;
}

uint32_t curve_next(struct curve *curve)
{
    (void)settle(curve, 1);
    if (curve->kind == CURVE_FLAT_NOT) {
        return curve_steep_next(&curve->state.steep);
    }
    curve->state.flat.steps++;
    return curve_flat_next(&curve->state.flat.flat, curve->kind == CURVE_FLAT_NARROW);
}

static void burst_steep(struct curve_steep *steep,
                        struct step_ring *ring,
                        uint8_t slot,
                        uint8_t count,
                        struct curve_made *made)
{
    *made = (struct curve_made){.steps = 0};
    for (; count != 0; count--) {
        uint16_t ticks = curve_steep_quick(steep);
        if (ticks == 0) {
            return;
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

void curve_burst(struct curve *curve,
                 struct step_ring *ring,
                 uint8_t slot,
                 uint8_t count,
                 struct curve_made *made)
{
    count = settle(curve, count);
    if (curve->kind == CURVE_FLAT_NOT) {
        burst_steep(&curve->state.steep, ring, slot, count, made);
    } else {
        curve->state.flat.steps = (uint16_t)(curve->state.flat.steps + count);
        curve_flat_burst(&curve->state.flat.flat,
                         curve->kind == CURVE_FLAT_NARROW,
                         ring,
                         slot,
                         count,
                         made);
    }
}
