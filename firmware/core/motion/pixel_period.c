// SPDX-License-Identifier: MIT
#include "motion/pixel_period.h"

#include "base/multiply.h" // multiply_u32_u16

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

void pixel_grid_start(struct pixel_grid *grid, const struct pixel_period *period)
{
    grid->period = period;
    grid->sum = 0;
}

uint32_t pixel_grid_advance(struct pixel_grid *grid)
{
    const struct pixel_period *period = grid->period;
    uint32_t room = period->divisor - period->remainder;

    if (grid->sum >= room) {
        grid->sum -= room;
        return period->whole_ticks + 1u;
    }
    grid->sum += period->remainder;
    return period->whole_ticks;
}

static struct pixel_shift product(uint32_t a, uint16_t b)
{
    uint32_t low = multiply_u32_u16((uint16_t)a, b);
    uint32_t high = multiply_u32_u16(a >> 16, b) + (low >> 16);

    return (struct pixel_shift){
        .low = (high << 16) | (uint16_t)low,
        .high = (uint16_t)(high >> 16),
    };
}

// remainder * share further, modulo divisor * scale; what is carried. Share: not above the scale.
static uint8_t add_fraction(struct pixel_shift *sum,
                            const struct pixel_period *period,
                            uint16_t share,
                            uint16_t scale)
{
    struct pixel_shift part = product(period->remainder, share);

    sum->low += part.low;
    sum->high = (uint16_t)(sum->high + part.high + (sum->low < part.low ? 1u : 0u));
    part = product(period->divisor, scale);
    if (sum->high < part.high || (sum->high == part.high && sum->low < part.low)) {
        return 0;
    }
    sum->high = (uint16_t)(sum->high - part.high - (sum->low < part.low ? 1u : 0u));
    sum->low -= part.low;
    return 1;
}

uint32_t pixel_shift_start(struct pixel_shift *shift,
                           const struct pixel_period *period,
                           uint16_t backlash_steps,
                           uint16_t line_speed)
{
    // P (V-B)/V with P = q + r/d:  q (V-B) = ticks * V + rest, so the place is
    // ticks + (rest * d + r (V-B)) / (d V), a sum of two fractions below 1.
    uint16_t share = (uint16_t)(line_speed - backlash_steps);
    uint32_t part = period->whole_ticks / line_speed;
    uint32_t over = multiply_u32_u16(period->whole_ticks - part * line_speed, share);
    uint32_t carried = over / line_speed;
    uint16_t rest = (uint16_t)(over - carried * line_speed);

    *shift = product(period->divisor, rest);
    return multiply_u32_u16(part, share) + carried +
           add_fraction(shift, period, share, line_speed);
}

uint32_t pixel_shift_advance(struct pixel_shift *shift,
                             const struct pixel_period *period,
                             uint16_t line_speed)
{
    return period->whole_ticks + add_fraction(shift, period, line_speed, line_speed);
}
