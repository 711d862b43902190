// SPDX-License-Identifier: MIT
#include "clock/clock_out_plan.h"

#include "base/apart.h" // APART
#include "base/flash.h" // IN_FLASH

// Powers of two by which timer 2 divides, by its clock select bits from SELECT_FIRST on. Nothing
// that is asked for needs a timer that is not divided at all.
#define SELECT_FIRST 2u
#define SELECT_LAST  7u
static const char shifts[] IN_FLASH = {3, 5, 6, 7, 8, 10};
_Static_assert(sizeof shifts == SELECT_LAST - SELECT_FIRST + 1u, "a shift for each");

#define COUNTS_MAX 256u

// Prescaled ticks in so many parts of a half period, rounded.
static APART uint32_t counts_of(uint32_t timer_hz,
                                uint16_t hz,
                                uint8_t shift,
                                uint8_t parts)
{
    uint32_t half_periods_hz = ((uint32_t)hz * parts) << shift;

    return (timer_hz + half_periods_hz) / (2u * half_periods_hz);
}

struct clock_out_plan clock_out_plan_of(uint16_t hz, uint32_t timer_hz)
{
    struct clock_out_plan plan = {.select = SELECT_FIRST, .matches = 1};
    uint8_t shift = (uint8_t)flash_char(&shifts[0]);
    uint32_t counts = counts_of(timer_hz, hz, shift, 1);

    while (counts > COUNTS_MAX && plan.select != SELECT_LAST) {
        plan.select++;
        shift = (uint8_t)flash_char(&shifts[plan.select - SELECT_FIRST]);
        counts = counts_of(timer_hz, hz, shift, 1);
    }
    if (counts > COUNTS_MAX) {
        plan.matches = (uint8_t)((counts + COUNTS_MAX - 1u) / COUNTS_MAX);
        counts = counts_of(timer_hz, hz, shift, plan.matches);
    }
    plan.counts = (uint16_t)counts;
    return plan;
}
