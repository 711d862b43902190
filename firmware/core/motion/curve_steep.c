// SPDX-License-Identifier: MIT
#include "motion/curve_steep.h"

#include <stddef.h> // offsetof

#include "base/divide.h"   // divide_u32_u16
#include "base/multiply.h" // multiply_*
#include "motion/curve_steep_layout.h"

// Up to so many corrections of an extrapolated interval are cheaper than the other guess.
#define QUICK_CORRECTIONS 16u
// What the other guess may miss by, with ample room.
#define SLOW_CORRECTIONS 8192u
// Extrapolated intervals and those they come from.
#define QUICK_TICKS_MAX 0x7FFFu

#if defined(__AVR__)

_Static_assert(offsetof(struct curve_steep, at.residual) == CURVE_STEEP_RESIDUAL &&
                   offsetof(struct curve_steep, at.slope) == CURVE_STEEP_SLOPE &&
                   offsetof(struct curve_steep, at.step) == CURVE_STEEP_STEP &&
                   offsetof(struct curve_steep, at.step_high) == CURVE_STEEP_STEP + 4 &&
                   offsetof(struct curve_steep, at.half) == CURVE_STEEP_HALF &&
                   offsetof(struct wide, low) == CURVE_STEEP_WIDE_LOW,
               "known to curve_steep_fit.S");

// curve_steep_fit.S.

// The interval from a guess (1..2^24-1) of it, and the state behind the step; 0 and nothing changed
// when the guess is further off than so many ticks.
uint32_t curve_steep_fit(struct curve_steep *steep, uint32_t ticks, uint16_t corrections);

// Largest r with r * r <= value. 370 cycles.
uint16_t curve_steep_root(uint32_t value);

#else

static uint32_t curve_steep_fit(struct curve_steep *steep,
                                uint32_t ticks,
                                uint16_t corrections)
{
    int64_t twice_half = 2 * (int64_t)steep->at.half;
    int64_t step = ((int64_t)steep->at.step_high << 32) | steep->at.step;
    int64_t bend = steep->at.half * ((int64_t)ticks - 1);
    int64_t sum = wide_to(steep->at.slope) + bend;
    int64_t value = sum * ticks + wide_to(steep->at.residual) - step;
    int64_t difference = sum + bend;

    if (sum < 0 || difference < 0) {
        return 0;
    }
    for (; value < 0 || value >= difference; corrections--) {
        if (corrections == 0) {
            return 0;
        }
        if (value < 0) {
            difference += twice_half;
            value += difference;
            ticks++;
        } else {
            value -= difference;
            difference -= twice_half;
            ticks--;
        }
    }
    steep->at.residual = wide_from(value);
    steep->at.slope = wide_from(difference + twice_half);
    return ticks;
}

static uint16_t curve_steep_root(uint32_t value)
{
    uint16_t root = 0;

    for (uint16_t bit = 0x8000u; bit != 0; bit = (uint16_t)(bit >> 1)) {
        uint16_t trial = (uint16_t)(root | bit);
        if ((uint32_t)trial * trial <= value) {
            root = trial;
        }
    }
    return root;
}

#endif

void curve_steep_enter(struct curve_steep *steep,
                       const struct curve_place *at,
                       uint32_t ticks,
                       uint16_t start_speed,
                       uint16_t steps)
{
    uint8_t scale = 0;

    while (ticks < 0x00400000uL) {
        ticks <<= 8;
        scale = (uint8_t)(scale + 8u);
    }
    while (ticks < 0x40000000uL) {
        ticks <<= 1;
        scale++;
    }
    *steep = (struct curve_steep){
        .at = *at,
        .scaled_ticks = ticks,
        .ticks_scale = scale,
        .start_speed = start_speed,
        .steps = steps,
    };
}

static uint32_t shifted(uint32_t value, int8_t left)
{
    return left < 0 ? value >> -left : value << left;
}

// Speeds behind the last step and the next one, added, shifted left by root_scale, which is as much
// as 16 bits each allow.
static uint32_t both_speeds(struct curve_steep *steep)
{
    int32_t twice_half = 2 * (int32_t)steep->at.half;
    uint32_t growth = multiply_u32_u16((uint32_t)twice_half, steep->steps);
    uint32_t before =
        multiply_u32_u16(steep->start_speed, steep->start_speed) + 2u * growth;
    uint32_t after = before + 2u * (uint32_t)twice_half;
    uint8_t scale = 0;

    while ((before | after) < 0x01000000uL) {
        before <<= 8;
        after <<= 8;
        scale = (uint8_t)(scale + 4u);
    }
    while ((before | after) < 0x40000000uL) {
        before <<= 2;
        after <<= 2;
        scale++;
    }
    uint16_t first =
        steep->root != 0
            ? (uint16_t)shifted(steep->root, (int8_t)(scale - steep->root_scale))
            : curve_steep_root(before);
    steep->root = curve_steep_root(after);
    steep->root_scale = scale;
    return (uint32_t)first + steep->root;
}

static uint32_t slow_guess(struct curve_steep *steep)
{
    uint32_t speeds = both_speeds(steep);
    int8_t left = (int8_t)(steep->root_scale + 1 - steep->ticks_scale);

    if (speeds >> 16 != 0) {
        speeds >>= 1;
        left--;
    }
    uint16_t quotient = divide_u32_u16(steep->scaled_ticks, (uint16_t)speeds);
    return shifted(quotient, left) | 1u;
}

static uint16_t extrapolated(const struct curve_steep *steep)
{
    return (uint16_t)(2u * steep->last_ticks - steep->before_ticks);
}

static void remember(struct curve_steep *steep, uint32_t ticks)
{
    steep->before_ticks = steep->last_ticks;
    steep->last_ticks = ticks > QUICK_TICKS_MAX ? 0 : (uint16_t)ticks;
    steep->steps++;
}

uint16_t curve_steep_quick(struct curve_steep *steep)
{
    if (!steep->good) {
        return 0;
    }
    uint16_t ticks =
        (uint16_t)curve_steep_fit(steep, extrapolated(steep), QUICK_CORRECTIONS);
    steep->good = ticks != 0;
    if (ticks != 0) {
        steep->root = 0;
        remember(steep, ticks);
    }
    return ticks;
}

uint32_t curve_steep_next(struct curve_steep *steep)
{
    uint32_t ticks = curve_steep_quick(steep);

    if (ticks == 0) {
        ticks = curve_steep_fit(steep, slow_guess(steep), SLOW_CORRECTIONS);
        uint16_t miss = (uint16_t)(extrapolated(steep) + QUICK_CORRECTIONS - ticks);
        steep->good = ticks <= QUICK_TICKS_MAX && steep->last_ticks != 0 &&
                      steep->before_ticks != 0 && miss <= 2u * QUICK_CORRECTIONS;
        remember(steep, ticks);
    }
    return ticks;
}
