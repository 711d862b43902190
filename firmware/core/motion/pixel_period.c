// SPDX-License-Identifier: MIT
#include "motion/pixel_period.h"

#include "base/apart.h"    // APART
#include "base/divide.h"   // divide_with_rest
#include "base/multiply.h" // multiply_u32_u16

// Index of the lower half of a 32-bit number in memory, 0 or 1.
#define LOW_HALF (__BYTE_ORDER__ == __ORDER_BIG_ENDIAN__)

// *to += *by. Both are whole_ticks + remainder / divisor, and they have the divisor of *to.
static APART void add_period(struct pixel_period *to, const struct pixel_period *by)
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

// Compute timer_hz * den / num by doubling, one bit of timer_hz after the other: a product of 64
// bits would need a library of its own, which a small part has no room for.
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
        add_period(&sum, &same);
        if ((timer_hz & 0x80000000uL) != 0) {
            add_period(&sum, &tick);
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

// One half of a 32-bit number as it lies in memory: on a small part a product has factors of 16
// bits at most.
typedef uint16_t __attribute__((may_alias)) half;

// *a * b + *c * d + more, where b and d have 15 bits.
static uint32_t sum_of_products(
    const half *a, uint16_t b, const half *c, uint16_t d, uint16_t more)
{
    return (uint32_t)*a * b + (uint32_t)*c * d + more;
}

// A shifted grid begins at P (V-B)/V, where P = q + r/d is the pixel period, V the line speed and
// V-B the share. With q (V-B) = ticks * V + rest this is
//
//     ticks + N / (d V)   with N = rest * d + r (V-B), less than 2 d V
//
// Each further period adds r V to N. The remainder of N divided by V therefore never changes, and
// the whole part of N / V advances as the sum of a grid does.
//
// Store N / V as the grid's sum. Returns true when a whole tick is carried.
static APART bool start_fraction(struct pixel_grid *grid,
                                 uint16_t rest,
                                 uint16_t share,
                                 uint16_t line_speed)
{
    const half *divisor = (const half *)&grid->period->divisor;
    const half *remainder = (const half *)&grid->period->remainder;
    uint32_t low =
        sum_of_products(&divisor[LOW_HALF], rest, &remainder[LOW_HALF], share, 0);
    uint32_t high = sum_of_products(&divisor[1 - LOW_HALF],
                                    rest,
                                    &remainder[1 - LOW_HALF],
                                    share,
                                    (uint16_t)(low >> 16));
    uint16_t top = (uint16_t)(high >> 16);
    bool beyond = top >= line_speed; // N / V has 33 bits

    if (beyond) {
        top = (uint16_t)(top - line_speed);
    }
    struct quotient upper = divide_with_rest(top, (uint16_t)high, line_speed);
    struct quotient lower = divide_with_rest(upper.rest, (uint16_t)low, line_speed);
    half *sum = (half *)&grid->sum;

    sum[LOW_HALF] = lower.whole;
    sum[1 - LOW_HALF] = upper.whole;
    if (beyond || grid->sum >= grid->period->divisor) {
        grid->sum -= grid->period->divisor;
        return true;
    }
    return false;
}

// ticks * share / whole, rounded down; *rest is what the division leaves over.
static APART uint32_t share_of(uint32_t ticks,
                               uint16_t share,
                               uint16_t whole,
                               uint16_t *rest)
{
    uint32_t over = (uint32_t)(uint16_t)(ticks % whole) * share;
    struct quotient more =
        divide_with_rest((uint16_t)(over >> 16), (uint16_t)over, whole);

    *rest = more.rest;
    return multiply_u32_u16(ticks / whole, share) + more.whole;
}

uint32_t pixel_grid_start_shifted(struct pixel_grid *grid,
                                  const struct pixel_period *period,
                                  uint16_t backlash_steps,
                                  uint16_t line_speed)
{
    uint16_t share = (uint16_t)(line_speed - backlash_steps);
    uint16_t rest = 0;
    uint32_t whole = share_of(period->whole_ticks, share, line_speed, &rest);

    grid->period = period;
    return whole + start_fraction(grid, rest, share, line_speed);
}

uint32_t pixel_share_ticks(uint32_t ticks, uint16_t share, uint16_t whole)
{
    uint16_t rest = 0;

    return share_of(ticks, share, whole, &rest);
}
