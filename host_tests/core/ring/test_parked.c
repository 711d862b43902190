// SPDX-License-Identifier: MIT
// The count of a parked axis's idle periods, against the exact one: at every phase of the coarse
// clock, of the counter and of the moment at which the axis was parked.
#include <stdint.h>

#include "fakes/chance.h"
#include "ring/parked.h"
#include "unity.h"

void setUp(void)
{
    chance_seed(0x5EED0015uL);
}

void tearDown(void)
{
}

// Units of the coarse clock at an instant, as read: it counts from another instant than the timer.
static uint32_t units_at(uint64_t ticks, uint32_t phase_ticks)
{
    return (uint32_t)((ticks + phase_ticks) / PARKED_UNIT_TICKS);
}

static uint16_t counter_at(uint64_t ticks)
{
    return (uint16_t)(ticks % STEP_IDLE_TICKS);
}

// Park at one instant, ask at another; the clock is read `late` ticks behind the counter.
static void check(uint64_t parked, uint64_t asked, uint32_t phase_ticks, uint32_t late)
{
    uint16_t first = (uint16_t)(parked / STEP_IDLE_TICKS * 7u); // any count
    uint32_t base = parked_base(units_at(parked, phase_ticks), counter_at(parked), first);
    uint16_t exact = (uint16_t)(first + (uint16_t)(asked / STEP_IDLE_TICKS -
                                                   parked / STEP_IDLE_TICKS));

    TEST_ASSERT_EQUAL_UINT16(
        exact,
        parked_count(base, units_at(asked + late, phase_ticks), counter_at(asked)));
    TEST_ASSERT_EQUAL_UINT16(
        exact,
        parked_count_at(base,
                        (uint16_t)units_at(asked + late, phase_ticks),
                        counter_at(asked),
                        (uint16_t)(exact + chance_between(0, 900))));
}

static void every_phase_of_a_period(void)
{
    for (uint32_t parked = 0; parked < STEP_IDLE_TICKS; parked += 61u) {
        for (uint32_t asked = 0; asked < 2u * STEP_IDLE_TICKS; asked += 53u) {
            check(parked, parked + asked, 37, 0);
        }
    }
}

static void around_each_beginning(void)
{
    for (uint32_t phase = 0; phase < PARKED_UNIT_TICKS; phase++) {
        for (uint32_t asked = STEP_IDLE_TICKS - 3u; asked < STEP_IDLE_TICKS + 3u;
             asked++) {
            check(STEP_IDLE_TICKS - 1u, asked, phase, 0);
            check(0, asked, phase, PARKED_SLACK_TICKS);
        }
    }
}

// Far beyond 16 bits of periods and 32 bits of ticks and of units.
static void parked_for_days(void)
{
    for (uint16_t i = 0; i < 2000u; i++) {
        uint64_t parked = chance();
        uint64_t asked = parked + ((uint64_t)chance() << (chance() % 10u));
        check(parked, asked, chance() % 64u, chance() % PARKED_SLACK_TICKS);
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(every_phase_of_a_period);
    RUN_TEST(around_each_beginning);
    RUN_TEST(parked_for_days);
    return UNITY_END();
}
