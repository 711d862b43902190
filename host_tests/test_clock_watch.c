// SPDX-License-Identifier: MIT
#include <stdint.h>

#include "motion/clock_watch.h"
#include "unity.h"

#define ZERO_TICKS   1000000uL
#define PERIOD_TICKS ((uint32_t)533333)

static struct pixel_period period;
static struct clock_watch watch;
static uint16_t pixel;

void setUp(void)
{
    watch = (struct clock_watch){.following = false};
    (void)pixel_period_set(&period, 16000000uL, 30, 1);
    pixel = 999;
}

void tearDown(void)
{
}

static void check_edge(uint32_t ticks, uint32_t number, int16_t error_ticks)
{
    TEST_ASSERT_TRUE(clock_watch_edge(&watch, &period, ticks, &pixel));
    TEST_ASSERT_EQUAL_UINT16(number, pixel);
    TEST_ASSERT_EQUAL_INT16(error_ticks, watch.error_ticks);
}

static void edges_count_without_a_line(void)
{
    TEST_ASSERT_FALSE(clock_watch_edge(&watch, &period, 5, &pixel));
    TEST_ASSERT_FALSE(clock_watch_edge(&watch, &period, 500000uL, &pixel));
    TEST_ASSERT_EQUAL_UINT32(2, watch.edges);
    TEST_ASSERT_EQUAL_UINT16(999, pixel);
}

static void edges_before_the_line_are_not_its_own(void)
{
    clock_watch_follow(&watch, &period, ZERO_TICKS);
    TEST_ASSERT_FALSE(
        clock_watch_edge(&watch, &period, ZERO_TICKS - PERIOD_TICKS, &pixel));
    check_edge(ZERO_TICKS, 0, 0);
}

static void exact_clock_has_no_error(void)
{
    uint32_t sum = 0;

    clock_watch_follow(&watch, &period, ZERO_TICKS);
    for (uint16_t k = 0; k < 300; k++) {
        check_edge(ZERO_TICKS + sum / 3u, k, 0);
        sum += 1600000uL;
    }
    TEST_ASSERT_EQUAL_UINT16(0, watch.error_max_ticks);
    TEST_ASSERT_EQUAL_UINT32(300, watch.edges);
}

static void errors_and_their_largest(void)
{
    clock_watch_follow(&watch, &period, ZERO_TICKS);
    check_edge(ZERO_TICKS + 7u, 0, 7);
    check_edge(ZERO_TICKS + PERIOD_TICKS - 20u, 1, -20);
    check_edge(ZERO_TICKS + 2u * PERIOD_TICKS + 3u, 2, 3);
    TEST_ASSERT_EQUAL_UINT16(20, watch.error_max_ticks);
    clock_watch_follow(&watch, &period, ZERO_TICKS);
    TEST_ASSERT_EQUAL_UINT16(0, watch.error_max_ticks);
}

static void large_errors_saturate(void)
{
    clock_watch_follow(&watch, &period, ZERO_TICKS);
    check_edge(ZERO_TICKS + 40000uL, 0, INT16_MAX);
    check_edge(ZERO_TICKS + PERIOD_TICKS - 40000uL, 1, -INT16_MAX);
    TEST_ASSERT_EQUAL_UINT16(INT16_MAX, watch.error_max_ticks);
}

static void missing_edges_do_not_shift_the_numbers(void)
{
    clock_watch_follow(&watch, &period, ZERO_TICKS);
    check_edge(ZERO_TICKS, 0, 0);
    check_edge(ZERO_TICKS + 1600000uL + 2u, 3, 2);
    check_edge(ZERO_TICKS + 1600000uL + PERIOD_TICKS, 4, 0);
}

// No line waits this long for its clock, so that the line is no longer the reference.
static void a_long_gap_ends_the_line(void)
{
    clock_watch_follow(&watch, &period, ZERO_TICKS);
    check_edge(ZERO_TICKS, 0, 0);
    TEST_ASSERT_FALSE(
        clock_watch_edge(&watch, &period, ZERO_TICKS + 9u * PERIOD_TICKS, &pixel));
    TEST_ASSERT_FALSE(watch.following);
    TEST_ASSERT_FALSE(
        clock_watch_edge(&watch, &period, ZERO_TICKS + 10u * PERIOD_TICKS, &pixel));
    TEST_ASSERT_EQUAL_UINT32(3, watch.edges);
}

static void check_odd(uint32_t interval_ticks, bool odd)
{
    watch.known = false;
    (void)clock_watch_edge(&watch, &period, ZERO_TICKS, &pixel);
    TEST_ASSERT_EQUAL_UINT16(0, watch.odd);
    (void)clock_watch_edge(&watch, &period, ZERO_TICKS + interval_ticks, &pixel);
    TEST_ASSERT_EQUAL_UINT16(odd ? (interval_ticks >> 8 | 1u) : 0, watch.odd);
}

// A sixteenth of the period, either way.
static void intervals_out_of_tolerance_are_odd(void)
{
    check_odd(PERIOD_TICKS, false);
    check_odd(PERIOD_TICKS + PERIOD_TICKS / 16u, false);
    check_odd(PERIOD_TICKS + PERIOD_TICKS / 16u + 1u, true);
    check_odd(PERIOD_TICKS - PERIOD_TICKS / 16u, false);
    check_odd(PERIOD_TICKS - PERIOD_TICKS / 16u - 1u, true);
    check_odd(PERIOD_TICKS / 2u, true);
    check_odd(100, true);
}

static void an_edge_behind_a_rest_is_not_odd(void)
{
    (void)clock_watch_edge(&watch, &period, 5, &pixel);
    clock_watch_rest(&watch);
    (void)clock_watch_edge(&watch, &period, 7777777uL, &pixel);
    TEST_ASSERT_EQUAL_UINT16(0, watch.odd);
    clock_watch_forget(&watch);
    (void)clock_watch_edge(&watch, &period, 7777778uL, &pixel);
    TEST_ASSERT_EQUAL_UINT16(0, watch.odd);
}

static void time_wraps(void)
{
    const uint32_t zero = 0xFFFFFF00u;

    clock_watch_follow(&watch, &period, zero);
    check_edge(zero, 0, 0);
    check_edge(zero + PERIOD_TICKS - 1u, 1, -1);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(edges_count_without_a_line);
    RUN_TEST(edges_before_the_line_are_not_its_own);
    RUN_TEST(exact_clock_has_no_error);
    RUN_TEST(errors_and_their_largest);
    RUN_TEST(large_errors_saturate);
    RUN_TEST(missing_edges_do_not_shift_the_numbers);
    RUN_TEST(a_long_gap_ends_the_line);
    RUN_TEST(intervals_out_of_tolerance_are_odd);
    RUN_TEST(an_edge_behind_a_rest_is_not_odd);
    RUN_TEST(time_wraps);
    return UNITY_END();
}
