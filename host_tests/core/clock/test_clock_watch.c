// SPDX-License-Identifier: MIT
#include <stdint.h>
#include <string.h>

#include "clock/clock_watch.h"
#include "fakes/chance.h"
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

// How the next edge's error differs from that of the edge before: mostly by next to nothing, and
// often by as much as separates the edges that are near from the others.
static int32_t change_of_error(uint32_t period_ticks)
{
    int32_t bound_ticks =
        (int32_t)(chance_between(0, 1) == 0 ? period_ticks / 32u : 0x3FFu);
    int32_t change_ticks = (int32_t)chance_between(0, 6) - 3;

    if (chance_between(0, 2) == 0) {
        change_ticks += bound_ticks;
    }
    return chance_between(0, 1) == 0 ? -change_ticks : change_ticks;
}

// An edge that is near is taken the quick way, which says of it what the general way does.
static uint16_t compare_ways(uint32_t hz, uint16_t edges)
{
    struct clock_watch general;
    uint32_t planned_ticks = ZERO_TICKS;
    int32_t error_ticks = 0;
    uint16_t quick = 0;

    (void)pixel_period_set(&period, 16000000uL, hz, 1);
    watch = (struct clock_watch){.following = false};
    clock_watch_follow(&watch, &period, ZERO_TICKS);
    for (uint16_t k = 0; k < edges; k++) {
        uint16_t general_pixel = pixel;
        uint32_t before_ticks = watch.next_ticks;
        error_ticks += change_of_error(period.whole_ticks);
        if (error_ticks > 14 * (int32_t)watch.near_ticks ||
            error_ticks < -14 * (int32_t)watch.near_ticks) {
            error_ticks = 0;
        }
        memcpy(&general, &watch, sizeof watch);
        quick = (uint16_t)(quick + (watch.following && watch.near ? 1u : 0u));
        general.near = false;
        bool of_pixel = clock_watch_edge(
            &watch, &period, planned_ticks + (uint32_t)error_ticks, &pixel);
        TEST_ASSERT_EQUAL(of_pixel,
                          clock_watch_edge(&general,
                                           &period,
                                           planned_ticks + (uint32_t)error_ticks,
                                           &general_pixel));
        TEST_ASSERT_EQUAL_UINT16(general_pixel, pixel);
        TEST_ASSERT_EQUAL_MEMORY(&general, &watch, sizeof watch);
        planned_ticks += watch.next_ticks - before_ticks;
    }
    return quick;
}

static void both_ways_say_the_same(void)
{
    static const uint16_t hz[] = {1, 30, 480, 1000, 5000, 20000};

    chance_seed(0xC10C4uL);
    for (size_t i = 0; i < sizeof hz / sizeof hz[0]; i++) {
        TEST_ASSERT_GREATER_THAN_UINT16(100, compare_ways(hz[i], 400));
    }
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
    RUN_TEST(both_ways_say_the_same);
    return UNITY_END();
}
