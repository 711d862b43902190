// SPDX-License-Identifier: MIT
// One axis makes the whole worked example, from blocks to STEP edges: at every pixel edge it has
// the position that the example gives.
#include <stdbool.h>
#include <stdint.h>

#include "fakes/axis_bench.h"
#include "fakes/promise.h"
#include "fakes/worked_example.h"
#include "unity.h"

// Pixel edges of the line, from line zero on. The steps of the virtual interrupt are compared with
// them.
static struct pixel_grid grid;
static uint32_t edge_ticks;
static uint16_t edge; // number of that edge
static int32_t steps_at_zero;

void setUp(void)
{
    promise_broken = 0;
    bench_open(30, 1);
}

void tearDown(void)
{
    TEST_ASSERT_EQUAL_UINT16(0, promise_broken);
}

static void watch_edges(void)
{
    pixel_grid_start(&grid, &bench.period);
    edge_ticks = bench.zero_ticks + pixel_grid_advance(&grid);
    edge = 1;
    steps_at_zero = bench.steps;
}

// A step comes: the edges before it saw the position up to here.
static void pass_edges(uint16_t backlash, uint32_t step_ticks, int32_t position)
{
    while ((int32_t)(step_ticks - edge_ticks) > 0) {
        TEST_ASSERT_EQUAL_INT32(worked_position(backlash, edge), position);
        edge_ticks += pixel_grid_advance(&grid);
        edge++;
    }
}

static void check_newest_record(uint16_t backlash)
{
    const struct ledger *ledger = &bench.axis.ledger;
    struct pixel_record record =
        records_get(&ledger->records, (uint8_t)(ledger->records.count - 1u));

    TEST_ASSERT_EQUAL_UINT16(ledger->pixel, record.pixel);
    TEST_ASSERT_EQUAL_INT32(worked_position(backlash, record.pixel),
                            record.expected_steps);
    TEST_ASSERT_EQUAL_INT32(record.expected_steps, record.actual_steps);
}

static void run_worked_example(uint16_t backlash)
{
    uint32_t pixel = 0;

    TEST_ASSERT_TRUE(bench_start_line());
    watch_edges();
    while (!bench_finish_line()) {
        uint32_t start_ticks = bench.now_ticks;
        int32_t position = bench.steps - steps_at_zero;
        if (bench_period().pulse) {
            pass_edges(backlash, start_ticks, position);
        }
        if (bench.axis.ledger.pixel != pixel) {
            pixel = bench.axis.ledger.pixel;
            check_newest_record(backlash);
        }
    }
    // The last step falls on the last pixel edge before the trailing zero pixel.
    TEST_ASSERT_EQUAL_UINT16(worked_pixels(backlash) - (backlash != 0 ? 1u : 0u), edge);
    TEST_ASSERT_EQUAL_UINT32(worked_pixels(backlash), pixel);
}

static void check_worked_example(uint16_t backlash)
{
    TEST_ASSERT_TRUE(bench_queue_worked_example(backlash));
    TEST_ASSERT_EQUAL(AXIS_LOADED, bench.axis.life.state);
    run_worked_example(backlash);
    TEST_ASSERT_EQUAL_INT32(10836L + backlash, bench.steps);
    TEST_ASSERT_EQUAL_INT32(bench.steps, ledger_position(&bench.axis.ledger));
    TEST_ASSERT_EQUAL(AXIS_DONE, bench.axis.life.state);
    TEST_ASSERT_EQUAL_UINT16(1, bench.axis.ledger.lines_done);
}

static void worked_example(void)
{
    check_worked_example(0);
}

// A steep step costs more than that, and is made all the same.
static void worked_example_a_unit_at_a_time(void)
{
    bench.budget = 1;
    check_worked_example(0);
    bench.budget = 0;
}

static void worked_example_with_backlash_of_a_quarter(void)
{
    check_worked_example(250);
}

static void worked_example_with_backlash_of_a_pixel(void)
{
    check_worked_example(1000);
}

static void backlash_that_is_taken_up_already(void)
{
    TEST_ASSERT_TRUE(bench_queue_worked_example(250));
    TEST_ASSERT_TRUE(bench_queue_worked_example(250));
    run_worked_example(250);
    TEST_ASSERT_EQUAL_INT32(11086, bench.steps);
    TEST_ASSERT_EQUAL(AXIS_LOADED, bench.axis.life.state);
    TEST_ASSERT_TRUE(bench_start_line());
    while (!bench_finish_line()) {
        (void)bench_period();
    }
    TEST_ASSERT_EQUAL_INT32(11086 + 10836, bench.steps);
}

int main(void)
{
    UNITY_BEGIN();

    RUN_TEST(worked_example);
    RUN_TEST(worked_example_a_unit_at_a_time);
    RUN_TEST(worked_example_with_backlash_of_a_quarter);
    RUN_TEST(worked_example_with_backlash_of_a_pixel);
    RUN_TEST(backlash_that_is_taken_up_already);
    return UNITY_END();
}
