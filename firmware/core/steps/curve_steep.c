// SPDX-License-Identifier: MIT
#include "steps/curve_steep.h"

#include "base/apart.h"     // APART
#include "base/divide.h"    // divide_u32_u16
#include "base/multiply.h"  // multiply_*
#include "ring/step_ring.h" // struct step_ring

// Behind a guess that missed by no more than this, 40 bits are enough for the next step. A guess
// misses by the second difference g = 3c*c/d of the intervals (d: interval, c: its change from step
// to step) and by up to 4 ticks of rounding, so g was below 16. Let D be the last difference:
//   D above 2^28.9: c/d = 2h*d/D is below a fourteenth, and the next miss is below 23 + 4 ticks,
//       which is below 2^39 / D up to D = 2^34.2;
//   D above 2^34.2: T is below 2^24 and 2h below 2^15, so that g itself is below 2^39 / D - 4 up to
//       D = 2^36.4, the limit;
//   a smaller D leaves room for any miss that could follow.
#define MISS_MAX ((uint32_t)CURVE_STEEP_MISS_MAX)
// Longest interval to extrapolate from, ticks.
#define QUICK_TICKS_MAX 0x7FFFu
// Most of half the change between the first intervals of a piece, ticks: its square fits 16 bits.
#define START_CHANGE_MAX 255u

// Add an entry to the sum of the batch.
static APART void add_top(struct curve_steep *steep, uint16_t top)
{
    uint32_t sum = (uint32_t)top + (uint16_t)((steep->tops[1] << 8) | steep->tops[0]);

    steep->tops[0] = (uint8_t)sum;
    steep->tops[1] = (uint8_t)(sum >> 8);
    steep->tops[2] = (uint8_t)(steep->tops[2] + (uint8_t)(sum >> 16));
}

#if defined(__AVR__)

// In curve_steep_fit.S:

// The next interval, ticks, from a guess of it (1..2^24-1). Moves *steep behind the step.
uint32_t curve_steep_fit(struct curve_steep *steep, uint32_t ticks);

// Largest r with r * r <= value. 370 cycles.
uint16_t curve_steep_root(uint32_t value);

// In curve_steep_steps.S: make up to `count` steps as long as extrapolation is good. The entries'
// low bytes go to `low` and behind, where only the low byte of the address advances; their high
// bytes go 256 bytes higher, except the first one, which goes to steep->first_high. Returns the low
// byte of the address behind the last entry.
uint8_t curve_steep_steps(struct curve_steep *steep,
                          volatile uint8_t *low,
                          uint8_t count);

static inline uint8_t make_steep_steps(struct curve_steep *steep,
                                       volatile uint8_t *low,
                                       const volatile uint8_t *high,
                                       uint8_t slot,
                                       uint8_t count)
{
    volatile uint8_t *start = &low[slot];

    (void)high;
    return (uint8_t)(curve_steep_steps(steep, start, count) - (uint8_t)(uintptr_t)start);
}

#else

static uint32_t curve_steep_fit(struct curve_steep *steep, uint32_t ticks)
{
    int64_t half = steep->at.half;
    int64_t step = ((int64_t)steep->at.step << 16) | steep->at.step_low;
    int64_t misses = 1;
    int64_t value = 0;
    int64_t difference = 0;

    while (misses != 0) {
        int64_t bend = half * ((int64_t)ticks - 1);
        int64_t sum = wide_to(steep->at.slope) + bend;
        value = sum * ticks + wide_to(steep->at.residual) - step;
        difference = sum + bend;
        misses = value < 0 ? -1 - (-1 - value) / difference : value / difference;
        ticks = (uint32_t)(ticks - misses);
    }
    steep->at.residual = wide_from(value);
    steep->at.slope = wide_from(difference + 2 * half);
    return ticks;
}

static uint16_t curve_steep_root(uint32_t value)
{
    uint16_t root = 0;

    for (uint16_t bit = 0x8000u; bit != 0; bit = (uint16_t)(bit >> 1)) {
        uint16_t trial = (uint16_t)(root | bit);
        if ((uint32_t)trial * trial <= value) {
            root = trial;
        }
    }
    return root;
}

// Make one extrapolated step, computed modulo 2^40.
static void make_quick_step(struct curve_steep *steep)
{
    struct wide half = wide_from_int32(steep->at.half);
    struct wide twice_half = wide_add(half, half);
    uint16_t guess = (uint16_t)(steep->last_ticks + (uint32_t)steep->change);
    uint16_t ticks = guess;
    struct wide bend = wide_times(half, ticks);
    struct wide sum = wide_add(wide_sub(steep->at.slope, twice_half), bend);
    struct wide step = wide_from(((int64_t)steep->at.step << 16) | steep->at.step_low);
    struct wide value = wide_sub(wide_add(wide_times(sum, ticks), bend), step);
    struct wide difference = wide_add(sum, bend);

    value = wide_add(value, steep->at.residual);
    while (value.high < 0) {
        difference = wide_add(difference, twice_half);
        value = wide_add(value, difference);
        ticks++;
    }
    while (wide_sub(value, difference).high >= 0) {
        value = wide_sub(value, difference);
        difference = wide_sub(difference, twice_half);
        ticks--;
    }
    int16_t miss = (int16_t)(ticks - guess);
    steep->good =
        miss <= CURVE_STEEP_MISS_MAX && miss >= -CURVE_STEEP_MISS_MAX && ticks <= 0x8000u;
    steep->change = (int16_t)(ticks - (uint16_t)steep->last_ticks);
    steep->last_ticks = ticks;
    steep->at.residual = value;
    steep->at.slope = wide_add(difference, twice_half);
}

// The steps as curve_steep_steps.S makes them, for every other processor.
static uint8_t make_steep_steps(struct curve_steep *steep,
                                volatile uint8_t *low,
                                volatile uint8_t *high,
                                uint8_t slot,
                                uint8_t count)
{
    uint8_t made = 0;

    steep->tops[0] = 0;
    steep->tops[1] = 0;
    steep->tops[2] = 0;
    for (; made < count && steep->good; made++) {
        struct wide difference =
            wide_sub(steep->at.slope, wide_from_int32(2 * steep->at.half));
        if (difference.high >> 24 >= CURVE_STEEP_LIMIT) {
            break;
        }
        make_quick_step(steep);
        uint16_t top = (uint16_t)(steep->last_ticks - 1u);
        low[slot] = (uint8_t)top;
        if (made == 0) {
            steep->first_high = (uint8_t)(top >> 8);
        } else {
            high[slot] = (uint8_t)(top >> 8);
        }
        add_top(steep, top);
        slot++;
    }
    return made;
}

#endif

void curve_steep_enter(struct curve_steep *steep,
                       const struct curve_place *at,
                       uint16_t last_ticks,
                       int16_t change)
{
    steep->at = *at;
    steep->last_ticks = last_ticks;
    steep->change = change;
    steep->seen = 2;
    steep->good = last_ticks <= QUICK_TICKS_MAX;
}

// Extrapolate from the start speed, as if the piece had an interval before its first one. At the
// start speed v an interval has q = T/v ticks, and the next one is shorter by 2u = 2qh/(v*v). The
// first interval has q - u ticks, and one before it would have had q + u: that is kept as the last
// interval. This leaves out the second difference, 12*u*u/q. False when the numbers are too large.
static bool foresee_change(struct curve_steep *steep, uint32_t ticks, uint16_t speed)
{
    int16_t half = steep->at.half;

    if (speed <= (uint16_t)(ticks >> 16)) {
        return false;
    }
    uint16_t interval = divide_u32_u16(ticks, speed);
    uint32_t product = multiply_u32_u16(interval, (uint16_t)(half < 0 ? -half : half));
    if (interval > QUICK_TICKS_MAX - START_CHANGE_MAX || product >> 16 >= speed) {
        return false;
    }
    uint16_t change = divide_u32_u16(divide_u32_u16(product, speed), speed);
    if (change > START_CHANGE_MAX || (uint16_t)(change * change) > interval) {
        return false;
    }
    int16_t longer = (int16_t)(half < 0 ? (int16_t)change : -(int16_t)change);
    steep->last_ticks = (uint16_t)(interval - (uint16_t)longer);
    steep->change = (int16_t)(2 * longer);
    return true;
}

void curve_steep_start(struct curve_steep *steep,
                       const struct curve_place *at,
                       uint32_t ticks,
                       uint16_t start_speed)
{
    steep->at = *at;
    steep->seen = 2;
    steep->good = foresee_change(steep, ticks, start_speed);
    if (!steep->good) {
        // Guess the first interval, 2T / (v + sqrt(v*v + 4h)), to an eighth. v has 11 bits here.
        uint16_t speed = (uint16_t)(4u * start_speed);
        uint32_t square = multiply_u32_u16(speed, speed) +
                          multiply_u32_u16((uint32_t)(int32_t)at->half, 64);
        uint16_t speeds = (uint16_t)(speed + curve_steep_root(square));
        steep->last_ticks = 8u * ticks / speeds;
        steep->change = 0;
        steep->seen = 0;
    }
}

// Make a step from a guess that may be far off. The guess must not be so far off that 48 bits are
// not enough. The next interval is never below 0.41 of the last one, so that half the last interval
// is the smallest guess where the curve speeds up.
static uint32_t make_slow_step(struct curve_steep *steep)
{
    uint32_t last = steep->last_ticks;
    uint32_t guess = last + (uint32_t)steep->change;

    if (steep->seen != 0 && steep->at.half > 0 &&
        (steep->seen == 1 || (int32_t)guess < (int32_t)(last / 2u))) {
        guess = last / 2u;
    }
    uint32_t ticks = curve_steep_fit(steep, guess);
    uint32_t miss = ticks + MISS_MAX - guess;
    steep->good = steep->seen == 2 && miss <= 2u * MISS_MAX && ticks <= QUICK_TICKS_MAX;
    steep->change = steep->seen != 0 ? (int32_t)(ticks - last) : 0;
    steep->seen = steep->seen != 0 ? 2 : 1;
    steep->last_ticks = ticks;
    return ticks;
}

// Make extrapolated steps, computed modulo 2^40, as long as extrapolation is good. Returns how
// many.
static uint8_t make_quick_steps(struct curve_steep *steep,
                                volatile uint8_t *low,
                                volatile uint8_t *high,
                                uint8_t slot,
                                uint8_t count)
{
    uint8_t made = 0;

    if (steep->good) {
        made = make_steep_steps(steep, low, high, slot, count);
        steep->change = (int16_t)steep->change;
    }
    return made;
}

// Make extrapolated steps where 40 bits are not enough. Returns how many.
static uint8_t make_wide_steps(struct curve_steep *steep,
                               struct step_ring *ring,
                               uint8_t slot,
                               uint8_t count)
{
    uint8_t made = 0;

    for (; made < count && steep->good; made++) {
        uint16_t top = (uint16_t)(make_slow_step(steep) - 1u);
        ring->low[slot] = (uint8_t)top;
        if (made == 0) {
            steep->first_high = (uint8_t)(top >> 8);
        } else {
            ring->high[slot] = (uint8_t)(top >> 8);
        }
        add_top(steep, top);
        slot++;
    }
    return made;
}

static uint32_t sum_of_tops(const struct curve_steep *steep)
{
    return ((uint32_t)steep->tops[2] << 16) |
           (uint16_t)((steep->tops[1] << 8) | steep->tops[0]);
}

void curve_steep_burst(struct curve_steep *steep,
                       struct step_ring *ring,
                       uint8_t slot,
                       uint8_t count,
                       struct curve_made *made)
{
    uint8_t steps_made = make_quick_steps(steep, ring->low, ring->high, slot, count);

    if (steps_made == 0) {
        steps_made = make_wide_steps(steep, ring, slot, count);
    }
    *made = (struct curve_made){
        .ticks = sum_of_tops(steep) + steps_made,
        .steps = steps_made,
        .first_high = steep->first_high,
    };
}

uint32_t curve_steep_next(struct curve_steep *steep)
{
    volatile uint8_t low; // the high byte of one step is not stored

    return make_quick_steps(steep, &low, &low, 0, 1) != 0 ? steep->last_ticks
                                                          : make_slow_step(steep);
}
