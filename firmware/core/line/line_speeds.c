// SPDX-License-Identifier: MIT
#include "line/line_speeds.h"

#include "base/apart.h"  // APART
#include "base/divide.h" // divide_u32_u16

bool APART line_speeds_too_fast(uint16_t speed,
                                uint16_t interval_ticks,
                                uint32_t pixel_ticks)
{
    return (uint32_t)speed * interval_ticks > pixel_ticks;
}

// A seek needs longer intervals than other lines: the capture interrupt places the switch's edge
// among the steps.
static uint16_t shortest_interval(const struct line_check *check,
                                  const struct line_limits *limits)
{
    if (FEATURE_HOMING && check->one_way) {
        return limits->seek_min_interval_ticks;
    }
    return check->smooth ? limits->smooth_min_interval_ticks : limits->min_interval_ticks;
}

// speed * interval > pixel if and only if speed > floor(pixel / interval).
APART void line_speeds_allow(struct line_check *check, const struct line_limits *limits)
{
    uint16_t interval = shortest_interval(check, limits);

    check->top_speed = limits->pixel_ticks >> 16 < interval
                           ? divide_u32_u16(limits->pixel_ticks, interval)
                           : UINT16_MAX;
}

#if SEVERAL_AXES
bool line_speeds_fit(const struct line_check *check, const struct line_limits *limits)
{
    return !line_speeds_too_fast(
               check->fastest_plain, limits->min_interval_ticks, limits->pixel_ticks) &&
           !line_speeds_too_fast(check->fastest_smooth,
                                 limits->smooth_min_interval_ticks,
                                 limits->pixel_ticks);
}
#endif
