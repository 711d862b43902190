// SPDX-License-Identifier: MIT
#include "motion/curve.h"

#include "motion/step_ring.h" // struct step_ring

// Speed times T, upper bytes from 2^8 on.
#define FAST 0x00200000

bool curve_is_wide(uint32_t ticks, uint16_t start_speed, uint16_t steps)
{
    uint16_t end = (uint16_t)(2u * steps - start_speed);
    uint16_t top = end > start_speed ? end : start_speed;

    return wide_times(wide_from_int32((int32_t)ticks), top).high >= FAST &&
           curve_flat_kind(ticks, start_speed, end) == CURVE_FLAT_NOT;
}

void curve_start(struct curve *curve,
                 uint32_t ticks,
                 uint16_t start_speed,
                 uint16_t steps)
{
    uint16_t end_speed = (uint16_t)(2u * steps - start_speed);
    int16_t half = (int16_t)(steps - start_speed);

    curve->kind = curve_flat_kind(ticks, start_speed, end_speed);
    if (curve->kind == CURVE_FLAT_NOT) {
        curve_steep_start(&curve->state.steep, ticks, start_speed, half);
    } else {
        curve_flat_start(&curve->state.flat, ticks, start_speed, (int16_t)(2 * half));
    }
}

uint32_t curve_next(struct curve *curve)
{
    return curve->kind == CURVE_FLAT_NOT
               ? curve_steep_next(&curve->state.steep)
               : curve_flat_next(&curve->state.flat, curve->kind == CURVE_FLAT_NARROW);
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
    if (curve->kind == CURVE_FLAT_NOT) {
        burst_steep(&curve->state.steep, ring, slot, count, made);
    } else {
        curve_flat_burst(&curve->state.flat,
                         curve->kind == CURVE_FLAT_NARROW,
                         ring,
                         slot,
                         count,
                         made);
    }
}
