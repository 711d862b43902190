// SPDX-License-Identifier: MIT
// Where one axis begins to do something else, to the byte, the tick and the entry: when a line too
// long for the queue may be armed, how far ahead a seek is decoded, which trains are waited for,
// how many entries of a train fit, and when an account inside a train is due.
#include <stdint.h>

#include "axis/decode.h"
#include "fakes/axis_bench.h"
#include "fakes/promise.h"
#include "line/segment_pack.h"
#include "steps/train_pixel.h"
#include "unity.h"

#define PLAIN_MARK  ((int16_t)(LINE_MARK_START | LINE_START_WAIT))
#define QUEUE_BYTES (4u * BENCH_SLOTS)
#define TIMER_HZ    16000000uL

void setUp(void)
{
    promise_broken = 0;
}

void tearDown(void)
{
    TEST_ASSERT_EQUAL_UINT16(0, promise_broken);
}

// Pixels of so many ticks.
static void open_ticks(uint32_t ticks)
{
    bench_open(TIMER_HZ, ticks);
}

static void decode_far(void)
{
    for (uint8_t turns = 0; turns < 250u && !decode_is_ahead(&bench.axis); turns++) {
        (void)decode_axis(&bench.axis, &bench.period, 120);
    }
}

static void arm_run(int16_t count, uint16_t pixels)
{
    TEST_ASSERT_TRUE(bench_queue_run(PLAIN_MARK, count, pixels));
    TEST_ASSERT_TRUE(axis_arm(&bench.axis, &bench.period));
    decode_far();
}

static void queue_byte(void)
{
    static const uint8_t same_again = SEGMENT_NEAR_ZERO;

    TEST_ASSERT_EQUAL(BLOCK_TAKEN,
                      bench_queue_block(bench.axis.next_block, &same_again, 1, true));
}

// A line without its end may be armed when less than a quarter of the queue is free.
static void three_quarters_of_the_queue_are_enough(void)
{
    open_ticks(16000);
    TEST_ASSERT_EQUAL(BLOCK_TAKEN, bench_queue(PLAIN_MARK, 0));
    TEST_ASSERT_EQUAL(BLOCK_TAKEN, bench_queue(0, 0));
    TEST_ASSERT_EQUAL(BLOCK_TAKEN, bench_queue(3, 1));
    while (segment_queue_free(&bench.axis.queue) > QUEUE_BYTES / 4u) {
        TEST_ASSERT_EQUAL(AXIS_LOADING, bench.axis.life.state);
        queue_byte();
    }
    TEST_ASSERT_EQUAL(AXIS_LOADING, bench.axis.life.state);
    queue_byte();
    TEST_ASSERT_EQUAL_UINT16(QUEUE_BYTES / 4u - 1u,
                             segment_queue_free(&bench.axis.queue));
    TEST_ASSERT_EQUAL(AXIS_LOADED, bench.axis.life.state);
}

// Pixels of a seek, a step each, that are decoded while none of them is made.
static uint8_t pixels_of_a_seek(uint32_t ticks)
{
    open_ticks(ticks);
    bench.limits.seek_min_interval_ticks = 256;
    TEST_ASSERT_EQUAL(BLOCK_TAKEN,
                      bench_queue((int16_t)(LINE_MARK_START | LINE_START_SEEK), 0));
    TEST_ASSERT_EQUAL(BLOCK_TAKEN, bench_queue(0, 0));
    TEST_ASSERT_EQUAL(BLOCK_TAKEN, bench_queue(1, 40));
    TEST_ASSERT_EQUAL(BLOCK_TAKEN, bench_queue((int16_t)LINE_MARK_DOWN, 0));
    TEST_ASSERT_EQUAL(BLOCK_TAKEN, bench_queue(LINE_MARK_END, 0));
    TEST_ASSERT_TRUE(axis_arm(&bench.axis, &bench.period));
    decode_far();
    return (uint8_t)bench.axis.line.position;
}

// Another pixel is begun as long as no more than 2^17 ticks are decoded, here four pixels.
static void a_seek_is_decoded_a_little_ahead(void)
{
    TEST_ASSERT_EQUAL_UINT8(5, pixels_of_a_seek(0x7FFF));
    TEST_ASSERT_EQUAL_UINT8(5, pixels_of_a_seek(0x8000));
    TEST_ASSERT_EQUAL_UINT8(4, pixels_of_a_seek(0x8001));
}

// What the decoder does with a third pixel, while the first two are trains of so many ticks.
static uint8_t phase_behind_two_trains(uint32_t ticks)
{
    open_ticks(ticks);
    arm_run(122, 6);
    return bench.axis.phase;
}

// A train of 2^13 ticks is worth waiting for; the steps behind a shorter one become periods.
static void trains_are_awaited_from_a_length_on(void)
{
    if (!SEVERAL_AXES) {
        return; // it has no such pixels
    }
    TEST_ASSERT_EQUAL(DECODE_PIXEL_AWAITS_TRAIN,
                      phase_behind_two_trains(TRAIN_WAIT_TICKS));
    TEST_ASSERT_NOT_EQUAL(DECODE_PIXEL_AWAITS_TRAIN,
                          phase_behind_two_trains(TRAIN_WAIT_TICKS - 1u));
}

// A train takes what the ring has room for, less what the end of a piece may need: entries of 127
// steps each. The rest of the pixel follows later.
static void a_long_train_fills_the_ring(void)
{
    const struct stream *stream = &bench.axis.feed.stream;

    bench_open(8, 1);
    arm_run(16383, 2);
    TEST_ASSERT_EQUAL_UINT8(STEP_RING_CAPACITY - FEED_BURST + 1u, stream_used(stream));
    // The first step of the line is in its delay, the others of its pixel are a train; of the next
    // pixel as many as fit.
    TEST_ASSERT_EQUAL_UINT16(16382, stream->trains[0].steps);
    TEST_ASSERT_EQUAL_UINT16(112u * STEP_TRAIN_ENTRY_MAX, stream->trains[1].steps);
}

static void go_into_a_long_train(void)
{
    const struct axis *axis = &bench.axis;

    bench_open(8, 1);
    TEST_ASSERT_TRUE(bench_queue_run(PLAIN_MARK, 16383, 1));
    TEST_ASSERT_TRUE(bench_start_line());
    while (axis->ledger.train == LEDGER_NO_TRAIN || axis->feed.stream.retired < 8u) {
        (void)bench_period();
    }
}

// A period more of the train; then the account is due if it lags by eight entries. Returns by how
// many it lags; 0 between two entries, where the train may be over.
static uint8_t lag_inside_a_train(void)
{
    const struct axis *axis = &bench.axis;

    (void)step_engine_next(&bench.engine, &bench.ring);
    struct engine_sample sample = step_engine_sample(&bench.engine);
    if (sample.left == 0) {
        return 0;
    }
    uint8_t behind = (uint8_t)(sample.tail - axis->feed.stream.retired);
    TEST_ASSERT_EQUAL(behind >= 8u,
                      ledger_due(&axis->ledger, &axis->feed.stream, &sample));
    return behind;
}

// The account of a train that goes on can wait until eight of its entries were made.
static void an_account_inside_a_train_is_due_after_eight_entries(void)
{
    uint8_t most = 0;

    go_into_a_long_train();
    for (uint16_t i = 0; i < 10u * STEP_TRAIN_ENTRY_MAX; i++) {
        uint8_t lag = lag_inside_a_train();
        most = lag > most ? lag : most;
    }
    TEST_ASSERT_TRUE(most > 8u);
}

// A line that is over leaves the next one, queued in full, in front of a third one: that one may
// not change what a pixel is.
static void a_divider_behind_a_line_that_waits(void)
{
    open_ticks(16000);
    TEST_ASSERT_TRUE(bench_queue_run(PLAIN_MARK, 5, 2));
    TEST_ASSERT_TRUE(bench_queue_run(PLAIN_MARK, 6, 2));
    TEST_ASSERT_TRUE(bench_start_line());
    while (!bench_finish_line()) {
        (void)bench_period();
    }
    TEST_ASSERT_EQUAL(AXIS_LOADED, bench.axis.life.state);
    TEST_ASSERT_EQUAL(
        BLOCK_TAKEN, bench_queue((int16_t)(PLAIN_MARK | (int16_t)LINE_START_DIVIDER), 0));
    TEST_ASSERT_EQUAL(BLOCK_TAKEN, bench_queue(0, 0));
    TEST_ASSERT_EQUAL(BLOCK_REFUSED, bench_queue(3, 0));
    TEST_ASSERT_EQUAL(LINE_divider, bench.axis.line_error);
    TEST_ASSERT_EQUAL_UINT16(1, bench.divider);
}

// A decoder that finds nothing queued has taken no more than what it found before.
static void a_dry_queue_takes_nothing_of_the_budget(void)
{
    open_ticks(16000);
    TEST_ASSERT_EQUAL(BLOCK_TAKEN, bench_queue(PLAIN_MARK, 0));
    TEST_ASSERT_EQUAL(BLOCK_TAKEN, bench_queue(0, 0));
    for (uint16_t i = 0; i < (uint16_t)(BENCH_SLOTS / 4u * 3u); i++) {
        TEST_ASSERT_EQUAL(BLOCK_TAKEN, bench_queue((int16_t)(1 + (i & 1)), 1));
    }
    TEST_ASSERT_TRUE(bench_start_line());
    while (bench.axis.phase != DECODE_DRY) {
        (void)bench_period();
    }
    TEST_ASSERT_TRUE(stream_used(&bench.axis.feed.stream) != 0);
    bench.axis.phase = DECODE_PIECE; // as if an entry had come
    TEST_ASSERT_EQUAL_UINT8(120, decode_axis(&bench.axis, &bench.period, 120));
    TEST_ASSERT_EQUAL(DECODE_DRY, bench.axis.phase);
    TEST_ASSERT_TRUE(decode_is_ahead(&bench.axis));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(three_quarters_of_the_queue_are_enough);
    RUN_TEST(a_seek_is_decoded_a_little_ahead);
    RUN_TEST(trains_are_awaited_from_a_length_on);
    RUN_TEST(a_long_train_fills_the_ring);
    RUN_TEST(an_account_inside_a_train_is_due_after_eight_entries);
    RUN_TEST(a_divider_behind_a_line_that_waits);
    RUN_TEST(a_dry_queue_takes_nothing_of_the_budget);
    return UNITY_END();
}
