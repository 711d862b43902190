// SPDX-License-Identifier: MIT
#include "motion/curve_place.h"

#include "base/multiply.h" // multiply_*

void curve_place_start(struct curve_place *place,
                       uint32_t ticks,
                       uint16_t start_speed,
                       int16_t half)
{
    struct wide slope = wide_times(wide_from_int32((int32_t)ticks), start_speed);
    // T*T from the halves of T.
    uint16_t low = (uint16_t)ticks;
    uint16_t high = (uint16_t)(ticks >> 16);
    uint32_t square = multiply_u32_u16(low, low);
    uint32_t upper = multiply_u32_u16(2u * (uint32_t)low, high) + (square >> 16);

    place->residual = wide_from_int32(0);
    place->slope = wide_add(slope, wide_from_int32(half));
    place->step = (upper << 16) | (uint16_t)square;
    place->step_high = (uint16_t)((upper >> 16) + (uint16_t)(high * high));
    place->half = half;
}
