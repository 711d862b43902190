// SPDX-License-Identifier: MIT
// One axis whose lines are locked to the pixel clock, from blocks to STEP edges.
#include <stdbool.h>
#include <stdint.h>

#include "clock/lock_grid.h"
#include "fakes/axis_bench.h"
#include "fakes/promise.h"
#include "unity.h"

#define PLAIN_MARK    ((int16_t)(LINE_MARK_START | LINE_START_WAIT))
#define CHAINED_MARK  ((int16_t)LINE_MARK_START)
#define NOMINAL_TICKS 16000u // 1000 Hz
#define PIXEL_STEPS   10
#define LEAD_EDGES    3u

static struct lock_grid *grid;
static uint32_t period_ticks; // of the clock
static uint32_t clock_ticks;  // its newest edge

static void clock_edge(void)
{
    clock_ticks += period_ticks;
    TEST_ASSERT_EQUAL(true, clock_filter_edge(&grid->filter, clock_ticks));
}

// A clock that is off by so much has settled; its next edge is the line zero of the bench.
static void open_clock(int16_t off_ticks)
{
    bench_open(1000, 1);
    bench.limits.reversal_min_ticks = 1500;
    grid = lock_grid_now();
    *grid = (struct lock_grid){
        .locks = true, .divider = 1, .lead_edges = LEAD_EDGES, .pixel = bench.period};
    lock_grid_tolerate(NOMINAL_TICKS / 100u);
    grid->filter.hold_over = 4;
    clock_filter_aim(&grid->filter, NOMINAL_TICKS, LEAD_EDGES + 1u);
    period_ticks = NOMINAL_TICKS + (uint32_t)(int32_t)off_ticks;
    clock_ticks = bench.now_ticks + BENCH_DELAY_TICKS - 41u * period_ticks;
    for (uint8_t i = 0; i < 40; i++) {
        clock_edge();
    }
    TEST_ASSERT_EQUAL(true, clock_filter_settled(&grid->filter));
    lock_grid_hold_period();
}

void setUp(void)
{
    promise_broken = 0;
    open_clock(0);
}

void tearDown(void)
{
    TEST_ASSERT_EQUAL_UINT16(0, promise_broken);
    *lock_grid_now() = (struct lock_grid){.locks = false};
}

// The last step of every pixel lies on the clock's edge.
static void run_on_the_clock(void)
{
    uint16_t steps = 0;

    while (!bench_finish_line()) {
        while ((int32_t)(bench.now_ticks - clock_ticks - period_ticks) >= 0) {
            clock_edge();
        }
        uint32_t start_ticks = bench.now_ticks;
        if (bench_period().pulse && ++steps % PIXEL_STEPS == 0) {
            uint32_t edge = bench.zero_ticks + steps / PIXEL_STEPS * period_ticks;
            TEST_ASSERT_UINT32_WITHIN(2, edge, start_ticks);
        }
        TEST_ASSERT_NOT_EQUAL(STEP_ENGINE_HALTED, bench.engine.state);
    }
}

// A line that follows another one goes on along the clock's edges.
static void check_chained(int16_t off_ticks)
{
    open_clock(off_ticks);
    TEST_ASSERT_TRUE(bench_queue_run(PLAIN_MARK, PIXEL_STEPS, 7));
    TEST_ASSERT_TRUE(bench_queue_run(CHAINED_MARK, PIXEL_STEPS, 5));
    TEST_ASSERT_TRUE(bench_queue_run(CHAINED_MARK, -PIXEL_STEPS, 8));
    TEST_ASSERT_EQUAL(true, bench_start_line());
    TEST_ASSERT_EQUAL_UINT32(bench.zero_ticks, lock_grid_begin(1));
    line_grid_place(&bench.axis.line.edges, 0, bench.zero_ticks);
    run_on_the_clock();
    TEST_ASSERT_EQUAL_INT32(4 * PIXEL_STEPS, bench.steps);
    TEST_ASSERT_EQUAL_UINT16(3, bench.axis.lines_done);
    TEST_ASSERT_EQUAL_UINT32(8, bench.axis.ledger.pixel);
    TEST_ASSERT_EQUAL(AXIS_DONE, bench.axis.life.state);
}

static void chained_lines_stay_on_the_clock(void)
{
    check_chained(0);
    check_chained(40);
    check_chained(-100);
}

static void check_armed(bool locked, bool clocked)
{
    TEST_ASSERT_EQUAL(true, axis_arm(&bench.axis, &bench.period));
    TEST_ASSERT_EQUAL(locked, line_grid_locked(&bench.axis.line.edges));
    TEST_ASSERT_EQUAL(clocked, bench.axis.clocked);
    bench_open(1000, 1);
}

// Other lines have pixels of their own.
static void only_lines_that_wait_for_the_clock_are_locked(void)
{
    TEST_ASSERT_TRUE(bench_queue_run(PLAIN_MARK, PIXEL_STEPS, 3));
    check_armed(true, true);
    TEST_ASSERT_TRUE(bench_queue_run(CHAINED_MARK, PIXEL_STEPS, 3));
    check_armed(false, false);
}

static void the_setting_decides_what_a_line_waits_for(void)
{
    grid->locks = false;
    TEST_ASSERT_TRUE(bench_queue_run(PLAIN_MARK, PIXEL_STEPS, 3));
    check_armed(false, true);
    grid->ignored = true;
    TEST_ASSERT_TRUE(bench_queue_run(PLAIN_MARK, PIXEL_STEPS, 3));
    check_armed(false, false);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(chained_lines_stay_on_the_clock);
    RUN_TEST(only_lines_that_wait_for_the_clock_are_locked);
    RUN_TEST(the_setting_decides_what_a_line_waits_for);
    return UNITY_END();
}
