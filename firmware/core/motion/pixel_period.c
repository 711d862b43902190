// SPDX-License-Identifier: MIT
#include "motion/pixel_period.h"

#include "base/apart.h"    // APART
#include "base/divide.h"   // divide_with_rest
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

// a * b + c * d + more; b and d of 15 bits.
static APART uint32_t mix(uint16_t a, uint16_t b, uint16_t c, uint16_t d, uint16_t more)
{
    return (uint32_t)a * b + (uint32_t)c * d + more;
}

// P (V-B)/V with P = q + r/d:  q (V-B) = ticks * V + rest, so the place is
//
//     ticks + N / (d V)   with N = rest * d + r (V-B), less than 2 d V
//
// A step of P adds r V to N: what N leaves over when V divides it never changes, and N / V walks as
// the sum of a grid does.
uint32_t pixel_grid_start_shifted(struct pixel_grid *grid,
                                  const struct pixel_period *period,
                                  uint16_t backlash_steps,
                                  uint16_t line_speed)
{
    uint16_t share = (uint16_t)(line_speed - backlash_steps);
    uint32_t ticks = multiply_u32_u16(period->whole_ticks / line_speed, share);
    uint32_t over = divide_with_rest(
        (uint32_t)(uint16_t)(period->whole_ticks % line_speed) * share, line_speed);
    uint16_t rest = (uint16_t)(over >> 16);
    uint32_t low =
        mix((uint16_t)period->divisor, rest, (uint16_t)period->remainder, share, 0);
    uint32_t high = mix((uint16_t)(period->divisor >> 16),
                        rest,
                        (uint16_t)(period->remainder >> 16),
                        share,
                        (uint16_t)(low >> 16));
    bool beyond = (uint16_t)(high >> 16) >= line_speed; // N / V has 33 bits

    if (beyond) {
        high -= (uint32_t)line_speed << 16;
    }
    high = divide_with_rest(high, line_speed);
    low = divide_with_rest((high & 0xFFFF0000uL) | (uint16_t)low, line_speed);
    grid->period = period;
    grid->sum = (high << 16) | (uint16_t)low;
    ticks += (uint16_t)over;
    if (beyond || grid->sum >= period->divisor) {
        grid->sum -= period->divisor;
        ticks++;
    }
    return ticks;
}
