// SPDX-License-Identifier: MIT
#include "steps/curve_place.h"

#include "base/multiply.h" // multiply_*

void curve_place_start(struct curve_place *place,
                       uint32_t ticks,
                       uint16_t start_speed,
                       int16_t half)
{
    struct wide factor = wide_from_int32((int32_t)ticks);
    struct wide slope = wide_times(factor, start_speed);
    // T*T, as the sum of T times each half of T.
    struct wide lower = wide_times(factor, (uint16_t)ticks);
    uint32_t upper = multiply_u32_u16(ticks, (uint16_t)(ticks >> 16));

    place->residual = wide_from_int32(0);
    place->slope = wide_add(slope, wide_from_int32(half));
    place->step_low = (uint16_t)(((uint16_t)lower.high << 8) | lower.low);
    place->step = upper + ((uint32_t)lower.high >> 8);
    place->half = half;
}
