// SPDX-License-Identifier: MIT
#include "motion/pixel_period.h"

bool pixel_period_set(struct pixel_period *period,
                      uint32_t timer_hz,
                      uint32_t num,
                      uint32_t den)
{
    if (num == 0 || den == 0) {
        return false;
    }
    uint64_t ticks_num = (uint64_t)timer_hz * den;
    uint64_t whole = ticks_num / num;

    if (whole < PIXEL_PERIOD_MIN_TICKS || whole > PIXEL_PERIOD_MAX_TICKS) {
        return false;
    }
    period->whole_ticks = (uint32_t)whole;
    period->remainder = (uint32_t)(ticks_num - whole * num);
    period->divisor = num;
    return true;
}

void pixel_grid_start(struct pixel_grid *grid,
                      const struct pixel_period *period,
                      uint16_t scale)
{
    grid->whole_ticks = period->whole_ticks;
    grid->step = (uint64_t)period->remainder * scale;
    grid->divisor = (uint64_t)period->divisor * scale;
    grid->sum = 0;
}

uint32_t pixel_grid_advance(struct pixel_grid *grid)
{
    uint32_t ticks = grid->whole_ticks;

    grid->sum += grid->step;
    if (grid->sum >= grid->divisor) {
        grid->sum -= grid->divisor;
        ticks++;
    }
    return ticks;
}

uint32_t pixel_grid_shift(struct pixel_grid *grid,
                          const struct pixel_period *period,
                          uint16_t backlash_steps,
                          uint16_t line_speed)
{
    // P (V-B)/V with P = q + r/d:  q (V-B) = whole * V + rest, so the place is
    // whole + (rest * d + r (V-B)) / (d V), and that fraction is below 2.
    uint16_t share = (uint16_t)(line_speed - backlash_steps);
    uint64_t product = (uint64_t)period->whole_ticks * share;
    uint32_t ticks = (uint32_t)(product / line_speed);
    uint32_t rest = (uint32_t)(product - (uint64_t)ticks * line_speed);

    grid->sum = (uint64_t)rest * period->divisor + (uint64_t)period->remainder * share;
    while (grid->sum >= grid->divisor) {
        grid->sum -= grid->divisor;
        ticks++;
    }
    return ticks;
}
