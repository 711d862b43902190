// SPDX-License-Identifier: MIT
// Lines of one axis that say how many clock edges a pixel has.
#include <stdint.h>

#include "fakes/axis_bench.h"
#include "fakes/promise.h"
#include "unity.h"

#define PLAIN_MARK   ((int16_t)(LINE_MARK_START | LINE_START_WAIT))
#define CHAINED_MARK ((int16_t)LINE_MARK_START)

void setUp(void)
{
    promise_broken = 0;
    bench_open(30, 1);
}

void tearDown(void)
{
    TEST_ASSERT_EQUAL_UINT16(0, promise_broken);
}

static void run_to_the_end(void)
{
    while (!bench_finish_line()) {
        (void)bench_period();
        TEST_ASSERT_NOT_EQUAL(STEP_ENGINE_HALTED, bench.engine.state);
    }
}

static void queue_divided(int16_t mark, int16_t divider, int16_t count, uint16_t pixels)
{
    TEST_ASSERT_EQUAL(BLOCK_TAKEN, bench_queue(mark | (int16_t)LINE_START_DIVIDER, 0));
    TEST_ASSERT_EQUAL(BLOCK_TAKEN, bench_queue(0, 0));
    TEST_ASSERT_EQUAL(BLOCK_TAKEN, bench_queue(divider, 0));
    TEST_ASSERT_EQUAL(BLOCK_TAKEN, bench_queue(count, pixels));
    TEST_ASSERT_EQUAL(BLOCK_TAKEN, bench_queue(LINE_MARK_END, 0));
}

// The decoder passes the divider: it counted when it was queued.
static void divided_lines_chain(void)
{
    queue_divided(PLAIN_MARK, 2, 5, 3);
    queue_divided(CHAINED_MARK, 2, 6, 2);
    TEST_ASSERT_TRUE(bench_start_line());
    run_to_the_end();
    TEST_ASSERT_EQUAL_INT32(5 * 3 + 6 * 2, bench.steps);
    TEST_ASSERT_EQUAL_UINT16(2, bench.axis.ledger.lines_done);
    TEST_ASSERT_EQUAL_UINT16(0, segment_queue_fill(&bench.axis.queue));
}

// A chained line whose divider is still to come is not begun.
static void chained_line_without_its_divider_yet(void)
{
    queue_divided(PLAIN_MARK, 2, 5, 3);
    TEST_ASSERT_EQUAL(BLOCK_TAKEN, bench_queue(CHAINED_MARK | LINE_START_DIVIDER, 0));
    TEST_ASSERT_EQUAL(BLOCK_TAKEN, bench_queue(0, 0));
    TEST_ASSERT_TRUE(bench_start_line());
    run_to_the_end();
    TEST_ASSERT_EQUAL_INT32(15, bench.steps);
    TEST_ASSERT_EQUAL(AXIS_LOADING, bench.axis.life.state);
    TEST_ASSERT_EQUAL(BLOCK_TAKEN, bench_queue(2, 0));
    TEST_ASSERT_EQUAL(BLOCK_TAKEN, bench_queue(7, 1));
    TEST_ASSERT_EQUAL(BLOCK_TAKEN, bench_queue(LINE_MARK_END, 0));
    TEST_ASSERT_TRUE(bench_start_line());
    run_to_the_end();
    TEST_ASSERT_EQUAL_INT32(15 + 7, bench.steps);
}

// Behind a line in the same block no other divider is asked for as if the line stood alone.
static void second_divider_of_a_block(void)
{
    static const uint8_t lines[] = {0x02, 0x21, 0, 0, 0, 0, 0,    0,    0, 4, 0, 0, 0, 5,
                                    0,    1,    0, 2, 0, 0, 0x02, 0x21, 0, 0, 0, 0, 0, 0,
                                    0,    8,    0, 0, 0, 5, 0,    1,    0, 2, 0, 0};

    TEST_ASSERT_EQUAL(BLOCK_REFUSED, bench_queue_block(0, lines, sizeof lines, false));
    TEST_ASSERT_EQUAL(LINE_divider, bench.axis.line_error);
    TEST_ASSERT_EQUAL_UINT32(1, bench.axis.line_error_pixel);
    TEST_ASSERT_EQUAL_UINT16(0, segment_queue_fill(&bench.axis.queue));
}

static void refused_divider(void)
{
    bench.divider = 0;
    TEST_ASSERT_EQUAL(BLOCK_TAKEN, bench_queue(PLAIN_MARK | LINE_START_DIVIDER, 0));
    TEST_ASSERT_EQUAL(BLOCK_TAKEN, bench_queue(0, 0));
    TEST_ASSERT_EQUAL(BLOCK_REFUSED, bench_queue(4, 0));
    TEST_ASSERT_EQUAL(AXIS_REFUSED, bench.axis.life.state);
    TEST_ASSERT_EQUAL(LINE_divider, bench.axis.line_error);
    TEST_ASSERT_EQUAL_UINT32(1, bench.axis.line_error_pixel);
    TEST_ASSERT_EQUAL_UINT16(8, segment_queue_fill(&bench.axis.queue));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(divided_lines_chain);
    RUN_TEST(chained_line_without_its_divider_yet);
    RUN_TEST(second_divider_of_a_block);
    RUN_TEST(refused_divider);
    return UNITY_END();
}
