// SPDX-License-Identifier: MIT
#include "motion/pixel_period.h"

#include "base/apart.h"    // APART
#include "base/multiply.h" // multiply_u32_u16

// to += by, both whole + rest / divisor; the period's divisor is known.
static APART void add(struct pixel_period *to, const struct pixel_period *by)
{
    uint32_t room = to->divisor - by->remainder;

    to->whole_ticks += by->whole_ticks;
    if (to->remainder >= room) {
        to->whole_ticks++;
        to->remainder -= room;
    } else {
        to->remainder += by->remainder;
    }
}

// timer_hz * den / num bit by bit of timer_hz, by doubling: the product's 64 bits would need a
// library of their own on a small part.
bool pixel_period_set(struct pixel_period *period,
                      uint32_t timer_hz,
                      uint32_t num,
                      uint32_t den)
{
    struct pixel_period sum = {.divisor = num};

    if (num == 0) {
        return false;
    }
    struct pixel_period tick = {.whole_ticks = den / num, .remainder = den % num};

    for (uint8_t bits = 32; bits != 0; bits--) {
        struct pixel_period same = sum;
        add(&sum, &same);
        if ((timer_hz & 0x80000000uL) != 0) {
            add(&sum, &tick);
        }
        timer_hz <<= 1;
        if ((sum.whole_ticks | tick.whole_ticks) > PIXEL_PERIOD_MAX_TICKS) {
            return false;
        }
    }
    if (sum.whole_ticks < PIXEL_PERIOD_MIN_TICKS) {
        return false;
    }
    *period = sum;
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
