// SPDX-License-Identifier: MIT
// The clock as the lines' reference: what the settings make of it, its edges' numbers, when an edge
// is overdue, and which edges are measured.
#include <stdbool.h>
#include <stdint.h>

#include "app/axes/reference.h"
#include "clock/lock_grid.h"
#include "fakes/board.h"
#include "fakes/board_bench.h"
#include "hal/clock.h"
#include "stream/stream.h"
#include "unity.h"

// Time to decode a pixel of a locked line, 8,192 us; and to place a line.
#define LEAD_TICKS  (CONFIG_TIMER_HZ / 1000000uL * 8192uL)
#define PLACE_TICKS 0x14000uL
#define FAST_TICKS  0x4000uL
#define HOLD_OVER   3u

static const uint16_t rates_hz[] = {
    5, 30, 100, 333, 500, 976, 977, 1000, 1950, 2000, 4000, 5000};

#define RATES (sizeof rates_hz / sizeof rates_hz[0])

static uint32_t whole_ticks;

static void set_up_clock(uint16_t sync, uint16_t hz, uint16_t divider)
{
    *lock_grid_now() = (struct lock_grid){.locks = false};
    bench_power_on();
    bench_clock_off();
    bench_settings()->sync = sync;
    bench_settings()->pixel_hz_num[0] = 0;
    bench_settings()->pixel_hz_num[1] = hz;
    bench_settings()->divider = divider;
    bench_settings()->hold_over_edges = HOLD_OVER;
    bench_settings()->bus_timeout_ms = 0;
    reference_apply_settings();
    reference_measure_anew();
    whole_ticks = (uint32_t)(CONFIG_TIMER_HZ / hz);
}

void setUp(void)
{
}

void tearDown(void)
{
}

static void each_way_of_starting(void)
{
    for (uint16_t sync = SYNC_FREE; sync <= SYNC_LOCK; sync++) {
        set_up_clock(sync, 1000, 1);
        TEST_ASSERT_EQUAL(sync == SYNC_LOCK, lock_grid_now()->locks);
        TEST_ASSERT_EQUAL(sync == SYNC_FREE, lock_grid_now()->ignored);
        TEST_ASSERT_EQUAL_UINT8(HOLD_OVER, lock_grid_now()->filter.hold_over);
    }
}

static void a_pixel_is_so_many_edges(void)
{
    for (uint16_t divider = 1; divider <= 100; divider += 33u) {
        set_up_clock(SYNC_START, 1000, divider);
        TEST_ASSERT_EQUAL_UINT16(divider, lock_grid_now()->divider);
        TEST_ASSERT_EQUAL_UINT32(whole_ticks, reference_period()->whole_ticks);
        TEST_ASSERT_EQUAL_UINT32(whole_ticks * divider, reference_pixel()->whole_ticks);
    }
}

// The least number of edges that last longer than so many ticks, as far as a stream has marks.
static uint16_t edges_longer(uint32_t ticks, uint16_t divider)
{
    uint16_t edges = 1;

    while ((uint32_t)edges * whole_ticks <= ticks) {
        edges++;
    }
    uint16_t most = (uint16_t)(STREAM_WAYPOINTS * divider);
    return edges < most ? edges : most;
}

static void edges_ahead_are_time(void)
{
    for (size_t i = 0; i < RATES; i++) {
        for (uint16_t divider = 1; divider <= 5; divider++) {
            set_up_clock(SYNC_LOCK, rates_hz[i], divider);
            const struct lock_grid *grid = lock_grid_now();
            struct clock_filter filter = grid->filter;
            uint16_t ahead = edges_longer(LEAD_TICKS, divider);

            TEST_ASSERT_EQUAL_UINT16(ahead, grid->lead_edges);
#if SEVERAL_AXES
            uint16_t all = edges_longer(LEAD_TICKS + whole_ticks / 8u * 3u, divider);
            TEST_ASSERT_EQUAL_UINT16(all - ahead, grid->more_edges);
            ahead = all;
#endif
            clock_filter_aim(&filter, whole_ticks, (uint16_t)(ahead + divider));
            TEST_ASSERT_EQUAL_UINT8(filter.shift_final, grid->filter.shift_final);
            TEST_ASSERT_EQUAL_UINT32(whole_ticks, grid->filter.nominal_ticks);
            TEST_ASSERT_EQUAL_UINT16(PLACE_TICKS / whole_ticks + 1u,
                                     reference_place_edges());
        }
    }
}

static void the_period_may_be_off_by_the_tolerance(void)
{
    static const uint16_t tolerances_ppm[] = {50, 500, 2000, 10000};

    for (uint8_t i = 0; i < 4; i++) {
        set_up_clock(SYNC_LOCK, 30, 1);
        bench_settings()->lock_tolerance_ppm = tolerances_ppm[i];
        reference_apply_settings();
        uint32_t exact = (uint32_t)((uint64_t)whole_ticks * tolerances_ppm[i] / 1000000u);
        TEST_ASSERT_UINT32_WITHIN(1, exact + 1u, lock_grid_now()->tolerance_ticks);
    }
}

// Looks unit by unit; returns after how many the edge is overdue.
static uint32_t overdue_after_units(void)
{
    uint32_t units = 0;

    while (!reference_overdue()) {
        fake_pass(CLOCK_UNIT_TICKS);
        units++;
    }
    return units;
}

static void give_edge(uint32_t edge_ticks)
{
    uint16_t pixel = 0;

    (void)reference_edge(edge_ticks, &pixel);
}

// Of a lock 11/8 of a period and one more for each missing edge; else 12/8.
static void an_edge_is_overdue(void)
{
    for (size_t i = 0; i < RATES; i++) {
        set_up_clock(SYNC_START, rates_hz[i], 1);
        uint32_t eighth = whole_ticks / 512u;
        reference_await_edge();
        TEST_ASSERT_EQUAL_UINT32(12u * eighth + 8u, overdue_after_units());
        if (rates_hz[i] < 20) {
            continue; // three missing edges of such a clock are beyond 16 bits of eighths
        }
        set_up_clock(SYNC_LOCK, rates_hz[i], 1);
        reference_await_edge();
        TEST_ASSERT_EQUAL_UINT32(11u * eighth + 8u, overdue_after_units());
        give_edge(fake_now_ticks());
        give_edge(fake_now_ticks() + whole_ticks);
        for (uint8_t missing = 1; missing <= 2; missing++) {
            reference_edge_dropped();
            reference_await_edge();
            TEST_ASSERT_EQUAL_UINT8(missing, lock_grid_now()->filter.bridged);
            TEST_ASSERT_EQUAL_UINT32((11u + 8u * missing) * eighth + 8u,
                                     overdue_after_units());
        }
    }
}

// Of an unlocked clock the time-out begins anew when somebody looks, of a lock with the edge.
static void an_edge_restarts(uint16_t sync)
{
    set_up_clock(sync, 500, 1); // a period is whole units of every board's clock
    reference_await_edge();
    uint32_t most_units = overdue_after_units();
    TEST_ASSERT_TRUE(reference_overdue());
    give_edge(fake_now_ticks());
    TEST_ASSERT_FALSE(reference_overdue());
    TEST_ASSERT_EQUAL_UINT32(most_units, overdue_after_units());
    give_edge(fake_now_ticks() + whole_ticks);
    fake_pass(whole_ticks);
    TEST_ASSERT_FALSE(reference_overdue());
    TEST_ASSERT_EQUAL_UINT32(
        sync == SYNC_LOCK ? most_units - whole_ticks / CLOCK_UNIT_TICKS : most_units,
        overdue_after_units());
}

static void an_edge_restarts_the_time_out(void)
{
    for (uint16_t sync = SYNC_START; sync <= SYNC_LOCK; sync++) {
        an_edge_restarts(sync);
    }
}

static void edges_have_numbers(void)
{
    for (uint16_t sync = SYNC_FREE; sync <= SYNC_LOCK; sync++) {
        set_up_clock(sync, 1000, 1);
        uint16_t first = reference_number();
        uint32_t ticks = fake_now_ticks();
        for (uint16_t edge = 1; edge <= 20; edge++) {
            ticks += whole_ticks;
            give_edge(ticks);
            TEST_ASSERT_EQUAL_UINT16(first + edge, reference_number());
        }
        TEST_ASSERT_TRUE(reference_present());
        reference_rest();
        TEST_ASSERT_FALSE(reference_present());
        TEST_ASSERT_EQUAL_UINT16(first + 20u, reference_number());
    }
}

static void lost_edges_are_counted(void)
{
    set_up_clock(SYNC_START, 1000, 1);
    uint16_t first = reference_number();
    give_edge(fake_now_ticks());
    reference_count_lost(5);
    TEST_ASSERT_EQUAL_UINT16(first + 6u, reference_number());
    TEST_ASSERT_TRUE(reference_present());
}

static void a_dropped_edge_counts_and_the_clock_is_forgotten(void)
{
    set_up_clock(SYNC_START, 1000, 1);
    give_edge(fake_now_ticks());
    uint16_t number = reference_number();
    fake_pass(10uL * whole_ticks);
    reference_edge_dropped();
    TEST_ASSERT_EQUAL_UINT16(number + 1u, reference_number());
    TEST_ASSERT_FALSE(reference_present());
    TEST_ASSERT_FALSE(reference_overdue());
}

// A lock goes on by predicted edges, so many as hold_over_edges says.
static void a_lock_bridges_dropped_edges(void)
{
    set_up_clock(SYNC_LOCK, 1000, 1);
    give_edge(fake_now_ticks());
    give_edge(fake_now_ticks() + whole_ticks);
    uint16_t number = reference_number();
    for (uint16_t edge = 1; edge <= HOLD_OVER; edge++) {
        reference_edge_dropped();
        TEST_ASSERT_EQUAL_UINT16(number + edge, reference_number());
        TEST_ASSERT_TRUE(reference_present());
    }
    uint32_t edges = reference_watch()->edges;
    reference_edge_dropped();
    TEST_ASSERT_EQUAL_UINT16(number + HOLD_OVER, reference_number());
    TEST_ASSERT_EQUAL_UINT32(edges + 1u, reference_watch()->edges);
    TEST_ASSERT_FALSE(reference_present());
}

static enum edge_kind kind_of(uint32_t edge_ticks)
{
    uint16_t pixel = 0;

    return reference_edge(edge_ticks, &pixel);
}

// Returns the time of the edge that settled the lock.
static uint32_t settle_from(uint32_t ticks)
{
    while (!reference_settled()) {
        ticks += whole_ticks;
        TEST_ASSERT_NOT_EQUAL(EDGE_FALSE, kind_of(ticks));
    }
    return ticks;
}

// Half a period behind the edge before; also where the edge before was missing, which the false
// edge shows: then the number moves, and the edge is false all the same.
static void false_edge_behind(uint8_t missing)
{
    set_up_clock(SYNC_LOCK, 1000, 1);
    uint32_t ticks = settle_from(fake_now_ticks()) + missing * whole_ticks;
    uint16_t number = (uint16_t)(reference_number() + missing);

    TEST_ASSERT_EQUAL(EDGE_FALSE, kind_of(ticks + whole_ticks / 2u));
    TEST_ASSERT_EQUAL_UINT16(number, reference_number());
    TEST_ASSERT_NOT_EQUAL(EDGE_FALSE, kind_of(ticks + whole_ticks));
    TEST_ASSERT_EQUAL_UINT16(number + 1u, reference_number());
}

static void a_lock_knows_false_edges(void)
{
    false_edge_behind(0);
    false_edge_behind(1);
}

static void without_a_lock_no_edge_is_false(void)
{
    set_up_clock(SYNC_START, 1000, 1);
    TEST_ASSERT_NOT_EQUAL(EDGE_FALSE, kind_of(fake_now_ticks()));
    TEST_ASSERT_NOT_EQUAL(EDGE_FALSE, kind_of(fake_now_ticks() + 5u * whole_ticks / 2u));
    TEST_ASSERT_NOT_EQUAL(EDGE_FALSE, kind_of(fake_now_ticks() + 21u * whole_ticks / 8u));
}

static void a_line_is_followed_unless_it_is_locked(void)
{
    for (uint16_t sync = SYNC_START; sync <= SYNC_LOCK; sync++) {
        set_up_clock(sync, 1000, 1);
        reference_follow(fake_now_ticks());
        TEST_ASSERT_EQUAL(sync != SYNC_LOCK, reference_watch()->following);
        reference_rest();
        TEST_ASSERT_FALSE(reference_watch()->following);
    }
}

static bool edges_are_measured(void)
{
    clock_filter_restart(&lock_grid_now()->filter);
    give_edge(fake_now_ticks());
    return lock_grid_now()->filter.count != 0;
}

// With the clock on.
static void let_axis_run(uint16_t hz)
{
    limits_apply_settings();
    fake_pixel_clock(fake_now_ticks() + 5000u, hz, 1);
    bench_plain_line(0, 10, 2000);
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(1, COMMAND_ARM));
    TEST_ASSERT_TRUE(bench_until(0, AXIS_RUNNING));
}

// All edges at rest. While an axis runs, those of a slow clock.
static void measured_where_there_is_time(uint16_t clock_hz)
{
    set_up_clock(SYNC_START, clock_hz, 1);
#if SEVERAL_AXES
    TEST_ASSERT_TRUE(edges_are_measured());
    let_axis_run(clock_hz);
    bench_clock_off();
    bench_rounds(2);
    TEST_ASSERT_EQUAL(whole_ticks > FAST_TICKS, edges_are_measured());
#else
    TEST_ASSERT_TRUE(edges_are_measured());
#endif
}

static void fast_edges_are_measured_where_there_is_time(void)
{
    for (size_t i = 0; i < RATES; i++) {
        if (rates_hz[i] >= 100 && rates_hz[i] <= 1000) {
            measured_where_there_is_time(rates_hz[i]);
        }
    }
}

// An axis that runs comes first: the edge behind is not measured where another one waits already.
static void an_edge_that_others_wait_behind_is_not_measured(void)
{
    for (uint16_t runs = 0; runs <= 1; runs++) {
        set_up_clock(SYNC_START, 1000, 1);
        if (runs != 0) {
            let_axis_run(1000);
        } else {
            bench_clock_on();
        }
        fake_pass(3uL * whole_ticks);
        TEST_ASSERT_EQUAL(runs == 0, edges_are_measured());
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(each_way_of_starting);
    RUN_TEST(a_pixel_is_so_many_edges);
    RUN_TEST(edges_ahead_are_time);
    RUN_TEST(the_period_may_be_off_by_the_tolerance);
    RUN_TEST(an_edge_is_overdue);
    RUN_TEST(an_edge_restarts_the_time_out);
    RUN_TEST(edges_have_numbers);
    RUN_TEST(lost_edges_are_counted);
    RUN_TEST(a_dropped_edge_counts_and_the_clock_is_forgotten);
    RUN_TEST(a_lock_bridges_dropped_edges);
    RUN_TEST(a_lock_knows_false_edges);
    RUN_TEST(without_a_lock_no_edge_is_false);
    RUN_TEST(a_line_is_followed_unless_it_is_locked);
    RUN_TEST(fast_edges_are_measured_where_there_is_time);
    RUN_TEST(an_edge_that_others_wait_behind_is_not_measured);
    return UNITY_END();
}
