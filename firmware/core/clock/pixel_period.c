// SPDX-License-Identifier: MIT
#include "clock/pixel_period.h"

#include "base/apart.h"  // APART
#include "base/divide.h" // divide_product

bool pixel_period_set(struct pixel_period *period,
                      uint32_t timer_hz,
                      uint32_t num,
                      uint32_t den)
{
    uint32_t remainder = 0;
    uint32_t whole_ticks = divide_product(timer_hz, den, num, &remainder);

    if (whole_ticks < PIXEL_PERIOD_MIN_TICKS || whole_ticks > PIXEL_PERIOD_MAX_TICKS) {
        return false;
    }
    period->whole_ticks = whole_ticks;
    period->remainder = remainder;
    period->divisor = num;
    return true;
}

void pixel_grid_start(struct pixel_grid *grid, const struct pixel_period *period)
{
    grid->period = period;
    grid->sum = 0;
}

#if !defined(__AVR__)
uint32_t pixel_grid_advance(struct pixel_grid *grid)
{
    const struct pixel_period *period = grid->period;

    if (period->remainder == 0) {
        return period->whole_ticks;
    }
    uint32_t room = period->divisor - period->remainder;

    if (grid->sum >= room) {
        grid->sum -= room;
        return period->whole_ticks + 1u;
    }
    grid->sum += period->remainder;
    return period->whole_ticks;
}
#endif

// ticks * share / whole, rounded down; *rest is what the division leaves over.
static APART uint32_t share_of(uint32_t ticks,
                               uint16_t share,
                               uint16_t whole,
                               uint32_t *rest)
{
    return divide_product(ticks, share, whole, rest);
}

// A shifted grid begins at P (V-B)/V, where P = q + r/d is the pixel period, V the line speed and
// V-B the share. With q (V-B) = ticks * V + rest this is
//
//     ticks + N / (d V)   with N = rest * d + r (V-B), less than 2 d V
//
// Each further period adds r V to N. The remainder of N divided by V therefore never changes, and
// the whole part of N / V advances as the sum of a grid does: rest * d / V is the sum before the
// first step, r (V-B) / V is the remainder of that step, and 1 more where what both quotients leave
// over makes a whole.
APART uint32_t pixel_grid_start_shifted(struct pixel_grid *grid,
                                        const struct pixel_period *period,
                                        uint16_t backlash_steps,
                                        uint16_t line_speed)
{
    uint16_t share = (uint16_t)(line_speed - backlash_steps);
    uint32_t rest = 0;
    uint32_t over = 0;
    struct pixel_period step = {
        .whole_ticks = share_of(period->whole_ticks, share, line_speed, &rest),
        .remainder = share_of(period->remainder, share, line_speed, &over),
        .divisor = period->divisor,
    };

    grid->sum = share_of(period->divisor, (uint16_t)rest, line_speed, &rest);
    if ((uint16_t)rest + (uint16_t)over >= line_speed) {
        step.remainder++;
    }
    grid->period = &step;
    uint32_t ticks = pixel_grid_advance(grid);

    grid->period = period;
    return ticks;
}

uint32_t pixel_share_ticks(uint32_t ticks, uint16_t share, uint16_t whole)
{
    uint32_t rest = 0;

    return share_of(ticks, share, whole, &rest);
}
