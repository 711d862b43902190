// SPDX-License-Identifier: MIT
// The coarse clock's units against 64-bit arithmetic, at the clock of the part that runs this
// suite.
#include "fakes/board.h" // fake_pass
#include "hal/clock.h"
#include "unity.h"

#define TICKS_PER_MS ((uint32_t)(CONFIG_TIMER_HZ / 1000uL))

void setUp(void)
{
    fake_power_on();
}

void tearDown(void)
{
}

// Rounded down by less than one unit: a time is never cut short by more.
static void microseconds_become_units(void)
{
    for (uint32_t us = 0; us <= UINT16_MAX; us += 7u) {
        uint64_t ticks = (uint64_t)us * CONFIG_TIMER_HZ / 1000000u;
        uint32_t exact = (uint32_t)(ticks / CLOCK_UNIT_TICKS);

        TEST_ASSERT_EQUAL_UINT32(exact, clock_units_of_us((uint16_t)us));
    }
}

// Never fast, at most 3 % slow, over the wrap of 16 bits too.
static void milliseconds_last_up_to_3_percent_longer(void)
{
    uint32_t counted_ms = 0;
    uint32_t passed_ms = 0;
    uint16_t before_ms = clock_now_ms();

    while (passed_ms < 150000u) {
        fake_pass(10uL * TICKS_PER_MS);
        passed_ms += 10u;
        uint16_t now_ms = clock_now_ms();
        counted_ms += (uint16_t)(now_ms - before_ms);
        before_ms = now_ms;
        TEST_ASSERT_TRUE(counted_ms <= passed_ms);
        TEST_ASSERT_TRUE(counted_ms + 1u + passed_ms / 33u >= passed_ms);
    }
}

static void events_have_exact_milliseconds(void)
{
    for (uint64_t units = 0; units <= UINT32_MAX; units += 9999991u) {
        uint64_t exact = units * CLOCK_UNIT_TICKS / TICKS_PER_MS;

        TEST_ASSERT_EQUAL_UINT32((uint32_t)exact, clock_ms_of_units((uint32_t)units));
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(microseconds_become_units);
    RUN_TEST(milliseconds_last_up_to_3_percent_longer);
    RUN_TEST(events_have_exact_milliseconds);
    return UNITY_END();
}
