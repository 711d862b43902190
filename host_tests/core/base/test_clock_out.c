// SPDX-License-Identifier: MIT
// The board's own clock on a timer that only counts: the edges are where they should be, and the
// program always has time to move the compare register on.
#include <stdbool.h>
#include <stdint.h>

#include "base/clock_out.h"
#include "unity.h"

#define EDGES     9u
#define COUNTS_HZ ((uint32_t)250000)

static struct clock_out own;
static bool level;
static uint32_t now_counts;   // since the clock began
static uint32_t begun_counts; // of the last change of level

void setUp(void)
{
    level = false;
    now_counts = 0;
    begun_counts = 0;
}

void tearDown(void)
{
}

// Pass on to the next match; return whether the level changes there.
static bool pass_match(void)
{
    uint16_t counts = clock_out_counts(&own);
    bool next = clock_out_next_level(&own);

    TEST_ASSERT_GREATER_OR_EQUAL_UINT16(CLOCK_OUT_COUNTS_MIN, counts);
    TEST_ASSERT_LESS_OR_EQUAL_UINT16(CLOCK_OUT_COUNTS_MAX, counts);
    clock_out_match(&own);
    TEST_ASSERT_EQUAL(next, own.high);
    now_counts += counts;
    if (next == level) {
        return false;
    }
    level = next;
    return true;
}

// Counts of the level that ends at the next change.
static uint32_t pass_level(void)
{
    while (!pass_match()) {
    }
    uint32_t lasted = now_counts - begun_counts;

    begun_counts = now_counts;
    return lasted;
}

static void check_clock(uint16_t hz, uint32_t counts_hz, uint32_t period_counts)
{
    setUp();
    clock_out_begin(&own, clock_out_period_counts(hz, counts_hz));
    for (uint8_t i = 0; i < EDGES; i++) {
        TEST_ASSERT_EQUAL_UINT32(period_counts - period_counts / 2u, pass_level());
        TEST_ASSERT_TRUE(level);
        TEST_ASSERT_EQUAL_UINT32(period_counts / 2u, pass_level());
        TEST_ASSERT_FALSE(level);
    }
}

static void slow_and_fast_clocks(void)
{
    check_clock(1, COUNTS_HZ, 250000);
    check_clock(30, COUNTS_HZ, 8333);
    check_clock(1000, COUNTS_HZ, 250);
    check_clock(2000, COUNTS_HZ, 125);
    check_clock(1, 312500uL, 312500uL);
    check_clock(2000, 312500uL, 156);
}

// Half periods of 257 to 318 counts: not one match of 256 and a short rest.
static void clocks_a_little_over_a_wrap(void)
{
    for (uint16_t hz = 393; hz <= 487; hz++) {
        check_clock(hz, COUNTS_HZ, (COUNTS_HZ + hz / 2u) / hz);
    }
}

// Each frequency that can be set: the period is the nearest one, and no match is too near.
static void every_frequency(void)
{
    for (uint16_t hz = 100; hz <= CLOCK_OUT_HZ_MAX; hz++) {
        setUp();
        clock_out_begin(&own, clock_out_period_counts(hz, COUNTS_HZ));
        uint32_t period = pass_level() + pass_level();
        uint32_t off =
            period * hz > COUNTS_HZ ? period * hz - COUNTS_HZ : COUNTS_HZ - period * hz;
        TEST_ASSERT_LESS_OR_EQUAL_UINT32(hz / 2u, off);
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(slow_and_fast_clocks);
    RUN_TEST(clocks_a_little_over_a_wrap);
    RUN_TEST(every_frequency);
    return UNITY_END();
}
