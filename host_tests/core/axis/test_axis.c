// SPDX-License-Identifier: MIT
// One axis from blocks to STEP edges: the rules of its queue, chained and streamed lines.
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "axis/decode.h"
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

static enum block_result queue_block(uint16_t block)
{
    static const uint8_t entries[] = {
        0x00, 0x21, 0, 0, 0, 0, 0, 0, 0, 5, 0, 1, 0, 2, 0, 0};

    return bench_queue_block(block, entries, sizeof entries, false);
}

static void block_numbers(void)
{
    TEST_ASSERT_EQUAL(BLOCK_WRONG, queue_block(0xFFFF)); // no block before the first
    TEST_ASSERT_EQUAL(BLOCK_WRONG, queue_block(1));
    TEST_ASSERT_EQUAL(BLOCK_TAKEN, queue_block(0));
    TEST_ASSERT_EQUAL(BLOCK_REPEATED, queue_block(0));
    TEST_ASSERT_EQUAL_UINT16(16, segment_queue_fill(&bench.axis.queue));
    TEST_ASSERT_EQUAL(BLOCK_WRONG, queue_block(2));
    TEST_ASSERT_EQUAL(BLOCK_TAKEN, queue_block(1));
    TEST_ASSERT_EQUAL_UINT16(2, bench.axis.next_block);
    TEST_ASSERT_EQUAL_UINT8(2, bench.axis.whole_lines);
}

static void block_numbers_wrap(void)
{
    bench.axis.next_block = 0xFFFF;
    TEST_ASSERT_EQUAL(BLOCK_TAKEN, queue_block(0xFFFF));
    TEST_ASSERT_EQUAL(BLOCK_REPEATED, queue_block(0xFFFF));
    TEST_ASSERT_EQUAL(BLOCK_TAKEN, queue_block(0));
}

static void full_queue_takes_all_or_nothing(void)
{
    for (uint16_t i = 0; i < (uint16_t)(BENCH_SLOTS / 4u - 1u); i++) {
        TEST_ASSERT_EQUAL(BLOCK_TAKEN, queue_block(i));
    }
    TEST_ASSERT_EQUAL(BLOCK_TAKEN, bench_queue(PLAIN_MARK, 0));
    TEST_ASSERT_EQUAL(BLOCK_TAKEN, bench_queue(0, 0));
    TEST_ASSERT_EQUAL(BLOCK_TAKEN, bench_queue(1, 1));
    TEST_ASSERT_EQUAL(BLOCK_FULL, queue_block(bench.axis.next_block));
    TEST_ASSERT_EQUAL_UINT16(4, segment_queue_free(&bench.axis.queue));
    TEST_ASSERT_EQUAL(BLOCK_TAKEN, bench_queue(LINE_MARK_END, 0));
    TEST_ASSERT_EQUAL(BLOCK_FULL, bench_queue(PLAIN_MARK, 0));
}

static void refused_line_stays_out(void)
{
    // A start mark, its parameter and 10 pixels of 3 steps from rest: the line oscillates at its
    // first pixel.
    static const uint8_t entries[] = {0x00, 0x31, 0, 0, 0, 0, 0, 0, 0, 10, 0, 3};

    TEST_ASSERT_EQUAL(BLOCK_REFUSED,
                      bench_queue_block(0, entries, sizeof entries, false));
    TEST_ASSERT_EQUAL(AXIS_REFUSED, bench.axis.life.state);
    TEST_ASSERT_EQUAL(LINE_oscillates, bench.axis.line_error);
    TEST_ASSERT_EQUAL_UINT32(1, bench.axis.line_error_pixel);
    TEST_ASSERT_EQUAL_UINT16(0, segment_queue_fill(&bench.axis.queue));
    TEST_ASSERT_EQUAL(BLOCK_REFUSED, queue_block(0));
    TEST_ASSERT_FALSE(axis_arm(&bench.axis, &bench.period));
    axis_stop(&bench.axis);
    axis_discard(&bench.axis, bench.engine.tail);
    TEST_ASSERT_EQUAL(AXIS_EMPTY, bench.axis.life.state);
    TEST_ASSERT_EQUAL(BLOCK_TAKEN, queue_block(0));
    TEST_ASSERT_EQUAL(AXIS_LOADED, bench.axis.life.state);
}

static void states_while_loading(void)
{
    TEST_ASSERT_EQUAL(AXIS_EMPTY, bench.axis.life.state);
    (void)bench_queue(PLAIN_MARK, 0);
    TEST_ASSERT_EQUAL(AXIS_LOADING, bench.axis.life.state);
    TEST_ASSERT_TRUE(axis_waits_for_edge(&bench.axis));
    (void)bench_queue(0, 0);
    (void)bench_queue(3, 2);
    TEST_ASSERT_FALSE(axis_arm(&bench.axis, &bench.period));
    (void)bench_queue(LINE_MARK_END, 0);
    TEST_ASSERT_EQUAL(AXIS_LOADED, bench.axis.life.state);
    TEST_ASSERT_TRUE(axis_arm(&bench.axis, &bench.period));
    TEST_ASSERT_EQUAL(AXIS_ARMED, bench.axis.life.state);
}

static void run_to_the_end(void)
{
    while (!bench_finish_line()) {
        (void)bench_period();
        TEST_ASSERT_NOT_EQUAL(STEP_ENGINE_HALTED, bench.engine.state);
    }
}

static void plain_line_with_reversals(void)
{
    static const int16_t counts[] = {300, -300, 0, 120, -7, 1, -1, 300};
    static const int32_t positions[] = {300, 0, 0, 120, 113, 114, 113, 413};

    (void)bench_queue(PLAIN_MARK, 0);
    (void)bench_queue(0, 0);
    for (uint8_t i = 0; i < 8; i++) {
        TEST_ASSERT_EQUAL(BLOCK_TAKEN, bench_queue(counts[i], 1));
    }
    (void)bench_queue(LINE_MARK_END, 0);
    TEST_ASSERT_TRUE(bench_start_line());
    run_to_the_end();
    TEST_ASSERT_EQUAL_INT32(413, bench.steps);
    TEST_ASSERT_EQUAL_UINT8(8, bench.axis.ledger.records.count);
    for (uint8_t i = 0; i < 8; i++) {
        TEST_ASSERT_EQUAL_INT32(
            positions[i], records_get(&bench.axis.ledger.records, i).expected_steps);
        TEST_ASSERT_EQUAL_INT32(positions[i],
                                records_get(&bench.axis.ledger.records, i).actual_steps);
    }
}

static void queue_run(int16_t mark, int16_t count, uint16_t pixels)
{
    TEST_ASSERT_TRUE(bench_queue_run(mark, count, pixels));
}

// The line zero of a chained line is the end of the line before, so that the step times have no
// gap.
static void chained_lines(void)
{
    uint32_t last_step_ticks = 0;

    bench_open(1000, 1);
    bench.limits.reversal_min_ticks = 1600; // ten steps in 16000 ticks may just reverse
    queue_run(PLAIN_MARK, 10, 3);
    queue_run(CHAINED_MARK, 10, 2);
    queue_run(CHAINED_MARK, -10, 4);
    TEST_ASSERT_TRUE(bench_start_line());
    while (!bench_finish_line()) {
        uint32_t start_ticks = bench.now_ticks;
        if (bench_period().pulse) {
            last_step_ticks = start_ticks;
        }
    }
    TEST_ASSERT_EQUAL_INT32(10, bench.steps);
    TEST_ASSERT_EQUAL_UINT32(bench.zero_ticks + 9u * 16000uL, last_step_ticks);
    TEST_ASSERT_EQUAL_UINT16(3, bench.axis.ledger.lines_done);
    TEST_ASSERT_EQUAL_INT32(-40, records_get(&bench.axis.ledger.records, 3).actual_steps);
    TEST_ASSERT_EQUAL_UINT32(4, bench.axis.ledger.pixel);
    TEST_ASSERT_EQUAL(AXIS_DONE, bench.axis.life.state);
}

// A pixel of a third of a tick more than whole ones: nine lines of one pixel are as long as one
// line of nine.
static void chained_lines_keep_the_part_of_a_tick(void)
{
    uint32_t last_step_ticks = 0;

    queue_run(PLAIN_MARK, 10, 1);
    for (uint8_t i = 0; i < 8; i++) {
        queue_run(CHAINED_MARK, 10, 1);
    }
    TEST_ASSERT_TRUE(bench_start_line());
    while (!bench_finish_line()) {
        uint32_t start_ticks = bench.now_ticks;
        if (bench_period().pulse) {
            last_step_ticks = start_ticks;
        }
    }
    TEST_ASSERT_EQUAL_INT32(90, bench.steps);
    TEST_ASSERT_EQUAL_UINT32(bench.zero_ticks + 9u * 16000000uL / 30u, last_step_ticks);
}

// A smooth line of five pixels that takes up so much play.
static void queue_with_play(uint16_t flags, int16_t backlash_steps)
{
    static const int16_t counts[] = {0, 10, 20, 20, 10};
    uint16_t mark = LINE_MARK_START | LINE_START_SMOOTH | flags;

    TEST_ASSERT_EQUAL(BLOCK_TAKEN, bench_queue((int16_t)mark, 0));
    TEST_ASSERT_EQUAL(BLOCK_TAKEN, bench_queue(backlash_steps, 20));
    for (size_t i = 0; i < sizeof counts / sizeof counts[0]; i++) {
        TEST_ASSERT_EQUAL(BLOCK_TAKEN, bench_queue(counts[i], 1));
    }
    TEST_ASSERT_EQUAL(BLOCK_TAKEN, bench_queue(LINE_MARK_END, 0));
}

// Run to the end; return when the last step was.
static uint32_t run_to_the_last_step(void)
{
    uint32_t last_step_ticks = 0;

    while (!bench_finish_line()) {
        uint32_t start_ticks = bench.now_ticks;
        if (bench_period().pulse) {
            last_step_ticks = start_ticks;
        }
        TEST_ASSERT_NOT_EQUAL(STEP_ENGINE_HALTED, bench.engine.state);
    }
    return last_step_ticks;
}

// The same where lines take up their play, so that their pieces are a part of a pixel early: of all
// parts of a pixel up to the whole one.
static void check_chained_play(int16_t backlash_steps)
{
    bench_open(30, 1);
    queue_with_play(LINE_START_WAIT, backlash_steps);
    queue_with_play(LINE_START_NEGATIVE, backlash_steps);
    queue_with_play(0, backlash_steps);
    queue_with_play(LINE_START_NEGATIVE, backlash_steps);
    TEST_ASSERT_TRUE(bench_start_line());
    uint32_t last_step_ticks = run_to_the_last_step();
    TEST_ASSERT_EQUAL_UINT32(bench.zero_ticks + 20u * 16000000uL / 30u, last_step_ticks);
    TEST_ASSERT_EQUAL_INT32(0, bench.steps);
    TEST_ASSERT_EQUAL_INT32(0, ledger_position(&bench.axis.ledger));
}

static void chained_lines_with_play_keep_it_too(void)
{
    for (int16_t backlash_steps = 1; backlash_steps <= 20; backlash_steps++) {
        check_chained_play(backlash_steps);
    }
}

// A line counts when its last step is made, some pixels after its end mark was decoded.
static void lines_count_when_they_are_made(void)
{
    bench_open(1000, 1);
    queue_run(PLAIN_MARK, 10, 3);
    queue_run(CHAINED_MARK, 10, 3);
    queue_run(CHAINED_MARK, 10, 3);
    TEST_ASSERT_TRUE(bench_start_line());
    while (!bench_finish_line()) {
        (void)bench_period();
        TEST_ASSERT_INT32_WITHIN(
            15, bench.steps - 15, 30 * (int32_t)bench.axis.ledger.lines_done);
    }
    TEST_ASSERT_EQUAL_UINT16(3, bench.axis.ledger.lines_done);
}

// The end of the decoded time, seen from the present period.
static uint32_t decoded_end_ticks(void)
{
    return bench.now_ticks + decode_ahead_ticks(&bench.axis);
}

// Two pixels, each a pulse train, are decoded to their end. The end does not move while the
// interrupt continues.
static void time_ahead_inside_a_train(void)
{
    uint32_t end_ticks = 0;
    uint8_t inside = 0;

    bench_open(1000, 1);
    queue_run(PLAIN_MARK, 125, 2); // every interval 128 ticks, so nothing is rounded
    TEST_ASSERT_TRUE(bench_start_line());
    TEST_ASSERT_EQUAL(DECODE_OUTSIDE, bench.axis.phase);
    end_ticks = decoded_end_ticks();
    for (uint8_t i = 0; i < 200; i++) {
        (void)bench_period();
        TEST_ASSERT_EQUAL_UINT32(end_ticks, decoded_end_ticks());
        inside = (uint8_t)(inside + (bench.axis.ledger.train != LEDGER_NO_TRAIN ? 1 : 0));
    }
    TEST_ASSERT_GREATER_THAN_UINT8(150, inside);
}

// A pixel takes 129 entries: the second pixel does not fit behind the first one and is handed over
// in parts.
static void trains_longer_than_the_ring_has_room(void)
{
    bench_open(8, 1);
    queue_run(PLAIN_MARK, 16383, 2);
    TEST_ASSERT_TRUE(bench_start_line());
    while (!bench_finish_line()) {
        (void)bench_period();
    }
    TEST_ASSERT_EQUAL_INT32(2L * 16383, bench.steps);
    TEST_ASSERT_EQUAL_INT32(2L * 16383,
                            records_get(&bench.axis.ledger.records, 1).actual_steps);
}

static void waiting_line_is_not_chained(void)
{
    bench_open(1000, 1);
    queue_run(PLAIN_MARK, 10, 1);
    queue_run(PLAIN_MARK, 10, 1);
    TEST_ASSERT_TRUE(bench_start_line());
    run_to_the_end();
    TEST_ASSERT_EQUAL_INT32(10, bench.steps);
    TEST_ASSERT_EQUAL(AXIS_LOADED, bench.axis.life.state);
    TEST_ASSERT_TRUE(bench_start_line());
    run_to_the_end();
    TEST_ASSERT_EQUAL_INT32(20, bench.steps);
}

// A line that is longer than the queue may be armed when most of the queue is full.
static void queue_long_start(void)
{
    bench_open(1000, 1);
    (void)bench_queue(PLAIN_MARK, 0);
    (void)bench_queue(0, 0);
    for (uint8_t i = 0; i < 95; i++) {
        TEST_ASSERT_EQUAL(AXIS_LOADING, bench.axis.life.state);
        (void)bench_queue((int16_t)(1 + (i & 1)), 1);
    }
    TEST_ASSERT_EQUAL(AXIS_LOADED, bench.axis.life.state);
    TEST_ASSERT_TRUE(bench_start_line());
}

static void starving_halts_dry(void)
{
    queue_long_start();
    while (bench.engine.state != STEP_ENGINE_HALTED) {
        (void)bench_period();
        TEST_ASSERT_FALSE(bench_finish_line());
    }
    TEST_ASSERT_EQUAL(DECODE_DRY, bench.axis.phase);
    // The next interval would carry the last decoded step, so that this step was never made.
    TEST_ASSERT_EQUAL_INT32(141, bench.steps);
    TEST_ASSERT_EQUAL_INT32(141, ledger_position(&bench.axis.ledger));
}

static void streamed_line_goes_on(void)
{
    uint16_t queued = 95;
    int32_t wanted = 142;

    queue_long_start();
    while (!bench_finish_line()) {
        if (queued < 400 && segment_queue_free_entries(&bench.axis.queue) > 20) {
            TEST_ASSERT_EQUAL(BLOCK_TAKEN, bench_queue(3, 1));
            queued++;
            wanted += 3;
        } else if (queued == 400) {
            TEST_ASSERT_EQUAL(BLOCK_TAKEN, bench_queue(LINE_MARK_END, 0));
            queued++;
        }
        (void)bench_period();
    }
    TEST_ASSERT_EQUAL_INT32(wanted, bench.steps);
    TEST_ASSERT_EQUAL_UINT32(400, bench.axis.ledger.pixel);
}

static void refusal_in_a_running_line_lets_it_run_dry(void)
{
    queue_long_start();
    TEST_ASSERT_EQUAL(BLOCK_REFUSED, bench_queue(20000, 1));
    TEST_ASSERT_EQUAL(AXIS_RUNNING, bench.axis.life.state);
    TEST_ASSERT_EQUAL(LINE_out_of_range, bench.axis.line_error);
    TEST_ASSERT_EQUAL_UINT32(96, bench.axis.line_error_pixel);
}

static void discard_forgets_an_armed_line(void)
{
    queue_run(PLAIN_MARK, 10, 3);
    TEST_ASSERT_TRUE(axis_arm(&bench.axis, &bench.period));
    decode_axis(&bench.axis, &bench.period, 64);
    axis_stop(&bench.axis);
    axis_discard(&bench.axis, bench.engine.tail);
    TEST_ASSERT_EQUAL(AXIS_EMPTY, bench.axis.life.state);
    for (uint8_t i = 0; i < 20; i++) {
        TEST_ASSERT_FALSE(bench_period().pulse);
    }
    queue_run(PLAIN_MARK, 4, 2);
    TEST_ASSERT_TRUE(bench_start_line());
    run_to_the_end();
    TEST_ASSERT_EQUAL_INT32(8, bench.steps);
    TEST_ASSERT_EQUAL_INT32(8, ledger_position(&bench.axis.ledger));
}

// In a line that runs ahead of the clock, pixel edges lie inside the pixels: intervals longer than
// a period may directly follow shorter ones.
static void slow_steps_behind_a_dip(void)
{
    // Speeds 0 0 8 16 24 8 8 16 32 32 32 16 0
    static const int16_t counts[] = {0, 4, 12, 20, 16, 8, 12, 24, 32, 32, 24, 8};
    uint32_t longest_ticks = 0;
    uint32_t last_ticks = 0;

    TEST_ASSERT_EQUAL(BLOCK_TAKEN,
                      bench_queue(PLAIN_MARK | (int16_t)LINE_START_SMOOTH, 0));
    TEST_ASSERT_EQUAL(BLOCK_TAKEN, bench_queue(8, 32));
    for (size_t i = 0; i < sizeof counts / sizeof counts[0]; i++) {
        TEST_ASSERT_EQUAL(BLOCK_TAKEN, bench_queue(counts[i], 1));
    }
    TEST_ASSERT_EQUAL(BLOCK_TAKEN, bench_queue(LINE_MARK_END, 0));
    TEST_ASSERT_TRUE(bench_start_line());
    while (!bench_finish_line()) {
        uint32_t start_ticks = bench.now_ticks;
        if (bench_period().pulse) {
            uint32_t since_ticks = start_ticks - last_ticks;
            if (bench.steps > 53 && bench.steps < 61 && since_ticks > longest_ticks) {
                longest_ticks = since_ticks;
            }
            last_ticks = start_ticks;
        }
    }
    TEST_ASSERT_EQUAL_UINT32(66667, longest_ticks);
    TEST_ASSERT_EQUAL_INT32(192 + 8, bench.steps);
    TEST_ASSERT_EQUAL_INT32(bench.steps, ledger_position(&bench.axis.ledger));
    TEST_ASSERT_EQUAL_UINT32(bench.zero_ticks + 12u * 16000000uL / 30u, last_ticks);
}

static void warning_is_reported(void)
{
    (void)bench_queue(PLAIN_MARK | (int16_t)LINE_START_SMOOTH, 0);
    (void)bench_queue(0, 0);
    TEST_ASSERT_EQUAL(BLOCK_TAKEN, bench_queue(1, 4));
    TEST_ASSERT_EQUAL(LINE_ripple, bench.axis.line_warning);
}

static void check_queued(int16_t count, uint16_t repeat)
{
    struct segment segment;

    TEST_ASSERT_TRUE(segment_queue_pop(&bench.axis.queue, &segment));
    TEST_ASSERT_EQUAL_INT16(count, segment.count);
    TEST_ASSERT_EQUAL_UINT16(repeat, segment.repeat);
}

// The entries of a block are queued in their order.
static void block_of_several_entries(void)
{
    static const uint8_t block[] = {0, 0x21, 0, 0, 0, 0, 0, 0, 0, 5, 0, 3, 0, 7, 1, 2};

    TEST_ASSERT_EQUAL(BLOCK_TAKEN, bench_queue_block(0, block, sizeof block, false));
    check_queued(0x21, 0);
    check_queued(0, 0);
    check_queued(5, 3);
    check_queued(7, 0x102);
}

// Periods that are written one by one before a pixel's pulse train begins.
static uint8_t singles_before_the_train(uint8_t stagger, int16_t steps)
{
    uint8_t singles = 0;

    bench_open(1000, 1);
    bench_stagger(stagger);
    queue_run(PLAIN_MARK, steps, 1);
    TEST_ASSERT_TRUE(bench_start_line());
    for (uint8_t slot = 0; bench.ring.high[slot] != STEP_HIGH_TRAIN; slot++) {
        TEST_ASSERT_TRUE(bench.ring.high[slot] != STEP_HIGH_EMPTY);
        singles = (uint8_t)(singles + (bench.ring.high[slot] != STEP_HIGH_COMMAND));
    }
    run_to_the_end();
    TEST_ASSERT_EQUAL_INT32(steps, bench.steps);
    return singles;
}

static void trains_of_several_axes_begin_some_steps_apart(void)
{
    uint8_t first = singles_before_the_train(0, 100);

    TEST_ASSERT_EQUAL_UINT8(first + (SEVERAL_AXES ? 5u : 0u),
                            singles_before_the_train(6, 100));
}

// Single periods below 160 ticks would leave the step interrupt too little time to begin a train.
static void trains_of_short_intervals_begin_at_once(void)
{
    uint8_t first = singles_before_the_train(0, 101);

    TEST_ASSERT_EQUAL_UINT8(first, singles_before_the_train(6, 101));
}

// Intervals of 64768 and 64769 ticks: as a single period the longer one would read as a pulse
// train.
static void longest_single_period(void)
{
    bench_open(16000000, 20uL * 64768u + 10u);
    queue_run(PLAIN_MARK, 20, 4);
    TEST_ASSERT_TRUE(bench_start_line());
    run_to_the_end();
    TEST_ASSERT_EQUAL_INT32(80, bench.steps);
    TEST_ASSERT_EQUAL_INT32(80, ledger_position(&bench.axis.ledger));
    TEST_ASSERT_EQUAL_UINT32(4, bench.axis.ledger.pixel);
}

// An axis that once ran dry and went on does not count as dry when its next entry is merely late.
static void next_line_is_not_dry(void)
{
    queue_long_start();
    while (bench.axis.phase != DECODE_DRY) {
        (void)bench_period();
    }
    TEST_ASSERT_EQUAL(BLOCK_TAKEN, bench_queue(LINE_MARK_END, 0));
    run_to_the_end();
    TEST_ASSERT_EQUAL(AXIS_DONE, bench.axis.life.state);
    queue_run(PLAIN_MARK, 1, 1);
    TEST_ASSERT_TRUE(bench_start_line());
    TEST_ASSERT_NOT_EQUAL(DECODE_DRY, bench.axis.phase);
    run_to_the_end();
}

// Only the start mark of the following line has arrived: the line begins when that is possible.
static void chained_line_that_is_only_a_mark_yet(void)
{
    bench_open(1000, 1);
    queue_run(PLAIN_MARK, 10, 3);
    TEST_ASSERT_EQUAL(BLOCK_TAKEN, bench_queue(CHAINED_MARK, 0));
    TEST_ASSERT_TRUE(bench_start_line());
    run_to_the_end();
    TEST_ASSERT_EQUAL_INT32(30, bench.steps);
    TEST_ASSERT_EQUAL_UINT16(4, segment_queue_fill(&bench.axis.queue));
    TEST_ASSERT_EQUAL(BLOCK_TAKEN, bench_queue(0, 0));
    TEST_ASSERT_EQUAL(BLOCK_TAKEN, bench_queue(10, 2));
    TEST_ASSERT_EQUAL(BLOCK_TAKEN, bench_queue(LINE_MARK_END, 0));
    TEST_ASSERT_TRUE(bench_start_line());
    run_to_the_end();
    TEST_ASSERT_EQUAL_INT32(50, bench.steps);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(block_numbers);
    RUN_TEST(block_numbers_wrap);
    RUN_TEST(full_queue_takes_all_or_nothing);
    RUN_TEST(refused_line_stays_out);
    RUN_TEST(states_while_loading);
    RUN_TEST(plain_line_with_reversals);
    RUN_TEST(chained_lines);
    RUN_TEST(chained_lines_keep_the_part_of_a_tick);
    RUN_TEST(chained_lines_with_play_keep_it_too);
    RUN_TEST(lines_count_when_they_are_made);
    RUN_TEST(time_ahead_inside_a_train);
    RUN_TEST(trains_longer_than_the_ring_has_room);
    RUN_TEST(waiting_line_is_not_chained);
    RUN_TEST(starving_halts_dry);
    RUN_TEST(streamed_line_goes_on);
    RUN_TEST(refusal_in_a_running_line_lets_it_run_dry);
    RUN_TEST(discard_forgets_an_armed_line);
    RUN_TEST(slow_steps_behind_a_dip);
    RUN_TEST(warning_is_reported);
    RUN_TEST(block_of_several_entries);
    RUN_TEST(trains_of_several_axes_begin_some_steps_apart);
    RUN_TEST(trains_of_short_intervals_begin_at_once);
    RUN_TEST(longest_single_period);
    RUN_TEST(next_line_is_not_dry);
    RUN_TEST(chained_line_that_is_only_a_mark_yet);
    return UNITY_END();
}
