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

static struct pixel_fraction product(uint32_t a, uint16_t b)
{
    uint32_t low = multiply_u32_u16((uint16_t)a, b);
    uint32_t high = multiply_u32_u16(a >> 16, b) + (low >> 16);

    return (struct pixel_fraction){
        .low = (high << 16) | (uint16_t)low,
        .high = (uint16_t)(high >> 16),
    };
}

// sum + b modulo whole, of a sum below whole and b not above it; what is carried.
static uint8_t add_fraction(struct pixel_grid *grid, const struct pixel_fraction *b)
{
    const struct pixel_fraction *whole = &grid->divisor;
    uint32_t low = grid->sum.low + b->low;
    uint16_t high = (uint16_t)(grid->sum.high + b->high + (low < b->low ? 1u : 0u));
    uint8_t carry = 0;

    if (high > whole->high || (high == whole->high && low >= whole->low)) {
        high = (uint16_t)(high - whole->high - (low < whole->low ? 1u : 0u));
        low -= whole->low;
        carry = 1;
    }
    grid->sum = (struct pixel_fraction){.low = low, .high = high};
    return carry;
}

void pixel_grid_start(struct pixel_grid *grid,
                      const struct pixel_period *period,
                      uint16_t scale)
{
    grid->whole_ticks = period->whole_ticks;
    grid->step = product(period->remainder, scale);
    grid->divisor = product(period->divisor, scale);
    grid->sum = (struct pixel_fraction){0};
}

uint32_t pixel_grid_advance(struct pixel_grid *grid)
{
    return grid->whole_ticks + add_fraction(grid, &grid->step);
}

uint32_t pixel_grid_shift(struct pixel_grid *grid,
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
    struct pixel_fraction more = product(period->remainder, share);

    grid->sum = product(period->divisor, rest);
    return multiply_u32_u16(part, share) + carried + add_fraction(grid, &more);
}
