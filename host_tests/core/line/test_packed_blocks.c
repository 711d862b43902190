// SPDX-License-Identifier: MIT
// Packed blocks: what they say is checked and queued as runs of two words are, whole or not at all.
#include <string.h>

#include "cycles.h"
#include "fakes/axis_bench.h"
#include "unity.h"

#define PLAIN  0x01
#define SMOOTH 0x11
#define START  0x80, PLAIN, 0, 0, 0x80, 0, 0, 0
#define END    0x80, LINE_MARK_END, 0, 0

void setUp(void)
{
    cycles_start();
    bench_open(1000, 1);
}

void tearDown(void)
{
}

static enum block_result send(const uint8_t *bytes, uint8_t size)
{
    return bench_queue_block(bench.axis.next_block, bytes, size, true);
}

#define SEND(...)                                                                        \
    send((const uint8_t[]){__VA_ARGS__}, (uint8_t)sizeof((const uint8_t[]){__VA_ARGS__}))

static void check_refused(enum line_error error, uint32_t pixel)
{
    TEST_ASSERT_EQUAL(AXIS_REFUSED, bench.axis.life.state);
    TEST_ASSERT_EQUAL(error, bench.axis.line_error);
    TEST_ASSERT_EQUAL_UINT32(pixel, bench.axis.line_error_pixel);
}

static void check_next(int16_t count, uint16_t repeat)
{
    struct segment entry;

    TEST_ASSERT_TRUE(segment_queue_pop(&bench.axis.queue, &entry));
    TEST_ASSERT_EQUAL_INT16(count, entry.count);
    TEST_ASSERT_EQUAL_UINT16(repeat, entry.repeat);
}

// Differences go on from block to block, also behind a block of runs.
static void blocks_follow_each_other(void)
{
    TEST_ASSERT_EQUAL(BLOCK_TAKEN, SEND(START, 0x38 + 10, 0x38 - 1));
    TEST_ASSERT_EQUAL(BLOCK_TAKEN, SEND(0x38 + 3, 0x71, 0xFE));
    TEST_ASSERT_EQUAL(BLOCK_TAKEN, bench_queue(7, 300));
    TEST_ASSERT_EQUAL(BLOCK_TAKEN, SEND(0x38 + 1, END));
    TEST_ASSERT_EQUAL(AXIS_LOADED, bench.axis.life.state);
    TEST_ASSERT_EQUAL_UINT16(8 + 2 + 3 + 4 + 5, segment_queue_fill(&bench.axis.queue));
    check_next(PLAIN, 0);
    check_next(0, 0);
    check_next(10, 1);
    check_next(9, 1);
    check_next(12, 1);
    check_next(10, 2);
    check_next(7, 300);
    check_next(8, 1);
    check_next(LINE_MARK_END, 0);
}

static void whole_or_not_at_all(void)
{
    TEST_ASSERT_EQUAL(BLOCK_TAKEN, SEND(START, 0x38 + 10));
    uint16_t fill = segment_queue_fill(&bench.axis.queue);
    TEST_ASSERT_EQUAL(BLOCK_REFUSED, SEND(0x38, 0x38 + 1, 0x7F, 0xFF, 0x38));
    check_refused(LINE_too_fast, 4);
    TEST_ASSERT_EQUAL_UINT16(fill, segment_queue_fill(&bench.axis.queue));
    TEST_ASSERT_EQUAL_INT16(10, bench.axis.queue.last);
}

// An entry that needs a closer look counts from the easy ones before it in the same block, either
// way: 200, 199 and then 99 more are too fast at 16000 ticks a pixel, 64 a step. The first entry of
// a block is looked at closely.
static void an_entry_behind_easy_ones(void)
{
    TEST_ASSERT_EQUAL(BLOCK_TAKEN, SEND(START));
    TEST_ASSERT_EQUAL(BLOCK_TAKEN, bench_queue(200, 1));
    TEST_ASSERT_EQUAL(BLOCK_REFUSED, SEND(0x38, 0x38 - 1, 0x71, 99));
    check_refused(LINE_too_fast, 4);
    setUp();
    TEST_ASSERT_EQUAL(BLOCK_TAKEN, SEND(START));
    TEST_ASSERT_EQUAL(BLOCK_TAKEN, bench_queue(-200, 1));
    TEST_ASSERT_EQUAL(BLOCK_REFUSED, SEND(0x38, 0x38 + 1, 0x71, 0x100 - 99));
    check_refused(LINE_too_fast, 4);
}

// A divider is in full, and the next difference goes on from it.
static void divider_in_full(void)
{
    TEST_ASSERT_EQUAL(BLOCK_TAKEN,
                      SEND(0x82, PLAIN, 0, 0, 0x80, 0, 0, 0, 0x80, 20, 0, 0, 0x39, END));
    TEST_ASSERT_EQUAL_UINT16(20, bench.divider);
    check_next(0x200 | PLAIN, 0);
    check_next(0, 0);
    check_next(20, 0);
    check_next(21, 1);
    bench_open(1000, 1);
    TEST_ASSERT_EQUAL(BLOCK_TAKEN, SEND(0x82, PLAIN, 0, 0, 0x80, 0, 0, 0));
    TEST_ASSERT_EQUAL(BLOCK_REFUSED, SEND(0x77, 20, 0));
    check_refused(LINE_malformed, 1);
    TEST_ASSERT_EQUAL_UINT16(1, bench.divider);
}

static void sums_out_of_range_are_refused(void)
{
    bench_open(1, 1);
    TEST_ASSERT_EQUAL(BLOCK_TAKEN, SEND(START, 0xBF, 0xFF, 0, 1));
    TEST_ASSERT_EQUAL(BLOCK_REFUSED, SEND(0x39));
    check_refused(LINE_out_of_range, 2);
}

static void full_queue_takes_no_block(void)
{
    uint8_t near[BENCH_BLOCK_MAX];

    memset(near, 0x38, sizeof near);
    TEST_ASSERT_EQUAL(BLOCK_TAKEN, SEND(START, 0x38 + 10));
    uint16_t room = segment_queue_free(&bench.axis.queue);
    for (; room > BENCH_BLOCK_MAX; room = segment_queue_free(&bench.axis.queue)) {
        TEST_ASSERT_EQUAL(BLOCK_TAKEN, send(near, 100));
    }
    uint8_t size = (uint8_t)room;
    TEST_ASSERT_EQUAL(BLOCK_TAKEN, send(near, (uint8_t)(size - 1u)));
    TEST_ASSERT_EQUAL(BLOCK_FULL, send(near, 2));
    TEST_ASSERT_EQUAL(BLOCK_TAKEN, send(near, 1));
    TEST_ASSERT_EQUAL(BLOCK_FULL, send(near, 1));
    TEST_ASSERT_EQUAL(AXIS_LOADED, bench.axis.life.state);
}

static void repeated_block_is_acknowledged(void)
{
    const uint8_t bytes[] = {START, 0x38 + 10};

    TEST_ASSERT_EQUAL(BLOCK_TAKEN, bench_queue_block(0, bytes, sizeof bytes, true));
    TEST_ASSERT_EQUAL(BLOCK_REPEATED, bench_queue_block(0, bytes, sizeof bytes, true));
    TEST_ASSERT_EQUAL(BLOCK_WRONG, bench_queue_block(2, bytes, sizeof bytes, true));
    TEST_ASSERT_EQUAL_UINT16(9, segment_queue_fill(&bench.axis.queue));
}

static void check_cut(const uint8_t *bytes, uint8_t size)
{
    bench_open(1000, 1);
    TEST_ASSERT_EQUAL(BLOCK_TAKEN, SEND(START, 0x38 + 10));
    TEST_ASSERT_EQUAL(BLOCK_REFUSED, send(bytes, size));
    check_refused(LINE_malformed, 2);
}

// A block ends inside an entry, of each size and after each of its bytes.
static void block_that_ends_inside_an_entry(void)
{
    const uint8_t full[] = {0x80, 1, 0, 1};
    const uint8_t run[] = {0x77, 1, 1};
    const uint8_t wide[] = {0x7C, 1};

    check_cut(full, 1);
    check_cut(full, 2);
    check_cut(full, 3);
    check_cut(run, 1);
    check_cut(run, 2);
    check_cut(wide, 1);
}

// A mark is found at the queue's front only if it is in full.
static void first_entries_are_in_full(void)
{
    TEST_ASSERT_EQUAL(BLOCK_REFUSED, SEND(0x77, PLAIN, 0, 0x80, 0, 0, 0));
    check_refused(LINE_malformed, 1);
    bench_open(1000, 1);
    TEST_ASSERT_EQUAL(BLOCK_REFUSED, SEND(0x80, PLAIN, 0, 0, 0x77, 0xFF, 0));
    check_refused(LINE_malformed, 1);
}

// The largest backlash has 15 bits, which are no negative count.
static void parameter_of_15_bits(void)
{
    struct line line;

    bench_open(1, 1);
    bench.limits.smooth_min_interval_ticks = 1;
    TEST_ASSERT_EQUAL(BLOCK_TAKEN,
                      SEND(0x80, SMOOTH, 0, 0, 0xFF, 0xFE, 0x7F, 0xFE, 0x80, 0, 0, 1));
    TEST_ASSERT_EQUAL_UINT16(32766, bench.axis.check.backlash_steps);
    line_begin(&line, &bench.period, &bench.axis.queue);
    TEST_ASSERT_EQUAL_UINT16(32766, line.backlash_steps);
    TEST_ASSERT_EQUAL_UINT16(32766, line.line_speed);
}

// The same line by runs and packed: the axis makes the same steps.
static int32_t steps_of_line(void)
{
    TEST_ASSERT_TRUE(bench_start_line());
    while (!bench_finish_line()) {
        (void)bench_period();
        TEST_ASSERT_NOT_EQUAL(STEP_ENGINE_HALTED, bench.engine.state);
    }
    return bench.steps;
}

static void packed_line_runs(void)
{
    TEST_ASSERT_EQUAL(
        BLOCK_TAKEN,
        SEND(START, 0x38 + 10, 0x38 + 5, 0x38 - 5, 0x73, 2, 0x77, 1, 20, 0x7C, 3, END));
    TEST_ASSERT_EQUAL_INT32(10 + 15 + 10 + 4 * 12 + 20 * 13 + 16, steps_of_line());
}

// Cycles a pixel of a packed block, from the request's bytes to the queue, checked.
static uint16_t queueing_cycles(uint8_t mark)
{
    const uint8_t begin[] = {0x80, mark, 0, 0, 0x80, 0, 0, 0, 0x3D, 0x3D, 0x3D};
    uint8_t bytes[96];

    bench.limits.pixel_ticks = 32000;
    TEST_ASSERT_EQUAL(BLOCK_TAKEN, send(begin, sizeof begin));
    bytes[0] = 0x38 + 5;
    for (size_t i = 1; i < sizeof bytes; i++) {
        bytes[i] = (i & 1u) != 0 ? 0x38 + 1 : 0x38 - 1;
    }
    uint16_t start = cycles_now();
    TEST_ASSERT_EQUAL(BLOCK_TAKEN, send(bytes, sizeof bytes));
    return (uint16_t)((uint16_t)(cycles_now() - start) / sizeof bytes);
}

static void budget_of_queueing(void)
{
    TEST_ASSERT_LESS_OR_EQUAL_UINT16(260, queueing_cycles(PLAIN));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(blocks_follow_each_other);
    RUN_TEST(whole_or_not_at_all);
    RUN_TEST(an_entry_behind_easy_ones);
    RUN_TEST(divider_in_full);
    RUN_TEST(sums_out_of_range_are_refused);
    RUN_TEST(full_queue_takes_no_block);
    RUN_TEST(repeated_block_is_acknowledged);
    RUN_TEST(block_that_ends_inside_an_entry);
    RUN_TEST(first_entries_are_in_full);
    RUN_TEST(parameter_of_15_bits);
    RUN_TEST(packed_line_runs);
    RUN_TEST(budget_of_queueing);
    return UNITY_END();
}
