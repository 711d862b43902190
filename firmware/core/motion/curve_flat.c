// SPDX-License-Identifier: MIT
#include "motion/curve_flat.h"

#include "base/multiply.h" // multiply_*

// What belongs to an interval of d ticks, all modulo 2^32:
//
//     gain         residual after d ticks, minus the residual before  = d*(slope + h*(d-1)) - T*T
//     difference   gain(d) - gain(d - 1)                               = slope + 2h*(d-1)
//     turn         growth of slope and difference over d ticks         = 2h*d
//     bend         growth of gain over d ticks                         = 2h*d*d
//
// A step of the same d adds turn and bend; a longer or shorter d moves all four: lengthen, shorten.
struct flat {
    uint32_t residual;
    uint32_t gain;
    uint32_t difference;
    uint32_t turn;
    uint32_t bend;
    uint16_t ticks; // d
};

static inline void lengthen(struct flat *flat, uint32_t twice_half)
{
    flat->difference += twice_half;
    flat->gain += flat->difference;
    flat->bend += 2u * flat->turn + twice_half;
    flat->turn += twice_half;
    flat->ticks++;
}

static inline void shorten(struct flat *flat, uint32_t twice_half)
{
    flat->gain -= flat->difference;
    flat->difference -= twice_half;
    flat->bend -= 2u * flat->turn - twice_half;
    flat->turn -= twice_half;
    flat->ticks--;
}

static struct flat enter(const struct curve *curve, uint32_t twice_half)
{
    int16_t half = curve->half_acceleration;
    uint16_t ticks = curve->last_ticks;
    uint32_t slope = (uint32_t)curve->state.narrow.slope;
    uint32_t half_bend = multiply_s16_s16(half, (int16_t)(ticks - 1u));
    uint32_t turn = 2u * half_bend + twice_half;

    return (struct flat){
        .residual = (uint32_t)curve->state.narrow.residual,
        .gain = multiply_u32_u16(slope + half_bend, ticks) - curve->state.narrow.step,
        .difference = slope + 2u * half_bend,
        .turn = turn,
        .bend = multiply_u32_u16(turn, ticks),
        .ticks = ticks,
    };
}

static void leave(struct curve *curve, const struct flat *flat, uint32_t twice_half)
{
    curve->state.narrow.residual = (int32_t)flat->residual;
    curve->state.narrow.slope = (int32_t)(flat->difference - flat->turn + twice_half);
    curve->last_ticks = flat->ticks <= curve->fast_limit_ticks ? flat->ticks : 0;
    curve->before_ticks = curve->last_ticks;
}

uint8_t curve_flat_batch(struct curve *curve, uint16_t *intervals, uint8_t count)
{
    uint32_t twice_half = (uint32_t)(2 * (int32_t)curve->half_acceleration);
    uint32_t negative_from = curve->state.narrow.negative_from;

    if (curve->last_ticks == 0) {
        return 0;
    }
    struct flat flat = enter(curve, twice_half);
    for (uint8_t left = count; left != 0; left--) {
        uint32_t value = flat.residual + flat.gain;
        while (value >= negative_from) {
            lengthen(&flat, twice_half);
            value += flat.difference;
        }
        while ((uint32_t)(value - flat.difference) < negative_from) {
            value -= flat.difference;
            shorten(&flat, twice_half);
        }
        flat.residual = value;
        flat.difference += flat.turn;
        flat.gain += flat.bend;
        *intervals = flat.ticks;
        intervals++;
    }
    leave(curve, &flat, twice_half);
    return count;
}
