// SPDX-License-Identifier: MIT
// Time, position and pixel edges, as the ledger finds them in the entries that were taken.
#include <stdint.h>

#include "account/ledger.h"
#include "fakes/promise.h"
#include "ring/step_engine.h"
#include "stream/feed.h"
#include "unity.h"

#define DELAY_TICKS 1500u
// A released line begins with the periods of its delay.
#define DELAY_PERIODS 2u

static struct step_ring ring;
static struct step_engine engine;
static struct feed feed;
static struct ledger ledger;
static uint32_t now_ticks; // end of the newest loaded period

void setUp(void)
{
    promise_broken = 0;
    step_engine_reset(&engine, &ring);
    records_thin(1, UINT16_MAX);
    ledger_reset(&ledger, STEP_IDLE_TICKS);
    feed.stream.ring = &ring;
    feed_reset(&feed, 0, false, ledger.loaded_ticks);
    now_ticks = 2uL * STEP_IDLE_TICKS;
}

void tearDown(void)
{
    TEST_ASSERT_EQUAL_UINT16(0, promise_broken);
}

static void load_periods(uint16_t count)
{
    for (; count != 0; count--) {
        now_ticks += (uint32_t)step_engine_next(&engine, &ring).top_ticks + 1u;
    }
}

static void advance(void)
{
    struct engine_sample sample = step_engine_sample(&engine);

    ledger_advance(&ledger, &feed.stream, &sample, LEDGER_EXACTLY);
}

static void step(uint32_t ticks, bool negative)
{
    feed_step(&feed, ticks, negative);
    while (feed_busy(&feed)) {
        feed_pump(&feed);
    }
}

static void begin_line(void)
{
    feed_hold(&feed);
    feed_mark_here(&feed, true, 0);
}

static void release(void)
{
    feed_release(&feed, feed.lead_in_ticks + DELAY_TICKS);
}

static void consume(void)
{
    while (engine.tail != feed.stream.head) {
        load_periods(1);
    }
    advance();
}

static void time_begins_with_two_periods(void)
{
    TEST_ASSERT_EQUAL_UINT32(8192, ledger.loaded_ticks);
    TEST_ASSERT_EQUAL_UINT32(4096, ledger_period_start(&ledger, &feed.stream, 0));
    TEST_ASSERT_EQUAL_UINT32(0, ledger_period_start(&ledger, &feed.stream, 1));
}

static void idle_periods_pass(void)
{
    load_periods(1000);
    advance();
    TEST_ASSERT_EQUAL_UINT32(now_ticks, ledger.loaded_ticks);
    TEST_ASSERT_EQUAL_UINT32(now_ticks - 3uL * STEP_IDLE_TICKS,
                             ledger_period_start(&ledger, &feed.stream, 2));
}

static void idle_count_wraps(void)
{
    engine.idle_count = 0xFFF0;
    ledger.idle_seen = 0xFFF0;
    load_periods(40);
    advance();
    TEST_ASSERT_EQUAL_UINT32(now_ticks, ledger.loaded_ticks);
}

static void steps_count_in_their_direction(void)
{
    begin_line();
    step(500, false);
    release();
    step(500, false);
    step(3000, true);
    step(600, true);
    step(600, true);
    feed_end(&feed);
    consume();
    TEST_ASSERT_EQUAL_INT32(-1, ledger.position_steps);
    TEST_ASSERT_TRUE(ledger.negative);
    TEST_ASSERT_EQUAL_UINT32(now_ticks, ledger.loaded_ticks);
}

static void position_is_what_was_loaded(void)
{
    begin_line();
    for (uint8_t i = 0; i < 10; i++) {
        step(500, false);
    }
    release();
    load_periods(DELAY_PERIODS + 3u);
    advance();
    TEST_ASSERT_EQUAL_INT32(3, ledger.position_steps);
    load_periods(2);
    advance();
    TEST_ASSERT_EQUAL_INT32(5, ledger.position_steps);
    TEST_ASSERT_EQUAL_UINT32(now_ticks, ledger.loaded_ticks);
}

static void starts_of_the_last_three_periods(void)
{
    begin_line();
    step(500, false);
    release();
    step(700, false);
    step(800, false);
    step(900, false);
    load_periods(DELAY_PERIODS + 3u);
    advance();
    TEST_ASSERT_EQUAL_UINT32(now_ticks - 900u,
                             ledger_period_start(&ledger, &feed.stream, 0));
    TEST_ASSERT_EQUAL_UINT32(now_ticks - 1700u,
                             ledger_period_start(&ledger, &feed.stream, 1));
    TEST_ASSERT_EQUAL_UINT32(now_ticks - 2400u,
                             ledger_period_start(&ledger, &feed.stream, 2));
}

// How far behind `now` an edge is placed that was captured at this count of a period.
static uint32_t placed(uint8_t back, uint16_t captured_ticks)
{
    return now_ticks - ledger_capture_ticks(&ledger, &feed.stream, back, captured_ticks);
}

// A capture that is no count of its period's, which is too short, is one of a period before.
static void a_capture_is_placed_in_a_period_that_is_long_enough(void)
{
    begin_line();
    step(500, false);
    release();
    step(900, false);
    step(800, false);
    step(700, false);
    load_periods(DELAY_PERIODS + 3u);
    advance();
    TEST_ASSERT_EQUAL_UINT32(700u, placed(0, 0));
    TEST_ASSERT_EQUAL_UINT32(700u - 699u, placed(0, 699));
    TEST_ASSERT_EQUAL_UINT32(1500u - 700u, placed(0, 700));
    TEST_ASSERT_EQUAL_UINT32(1500u - 799u, placed(0, 799));
    TEST_ASSERT_EQUAL_UINT32(2400u - 800u, placed(0, 800));
    TEST_ASSERT_EQUAL_UINT32(2400u - 899u, placed(0, 899));
    TEST_ASSERT_EQUAL_UINT32(1500u - 799u, placed(1, 799));
    TEST_ASSERT_EQUAL_UINT32(2400u - 800u, placed(1, 800));
    // No older period's length is known.
    TEST_ASSERT_EQUAL_UINT32(2400u - 950u, placed(0, 950));
    TEST_ASSERT_EQUAL_UINT32(2400u - 950u, placed(2, 950));
}

// The idle periods of a sample come after the sample's entries.
static void idle_after_entries(void)
{
    begin_line();
    step(500, false);
    release();
    step(700, false);
    feed_end(&feed);
    load_periods(DELAY_PERIODS + 2u);
    load_periods(5);
    advance();
    TEST_ASSERT_EQUAL_UINT32(now_ticks, ledger.loaded_ticks);
    TEST_ASSERT_EQUAL_UINT32(now_ticks - STEP_IDLE_TICKS,
                             ledger_period_start(&ledger, &feed.stream, 0));
    TEST_ASSERT_EQUAL_UINT32(now_ticks - 3uL * STEP_IDLE_TICKS,
                             ledger_period_start(&ledger, &feed.stream, 2));
}

static void mark_waits_for_the_step_before_it(void)
{
    begin_line();
    step(500, false);
    step(500, false);
    feed_mark_here(&feed, false, 2);
    release();
    step(500, false);
    load_periods(DELAY_PERIODS + 1u);
    advance();
    TEST_ASSERT_EQUAL_INT32(1, ledger.position_steps);
    TEST_ASSERT_EQUAL_UINT32(0, ledger.pixel);
    load_periods(1);
    advance();
    TEST_ASSERT_EQUAL_UINT32(1, ledger.pixel);
    TEST_ASSERT_EQUAL_INT32(2, records_get(&ledger.records, 0).expected_steps);
    TEST_ASSERT_EQUAL_INT32(2, records_get(&ledger.records, 0).actual_steps);
}

// A line of `pixels` pixels of two steps.
static void run_pixels(uint8_t pixels, bool negative)
{
    int32_t position = 0;

    begin_line();
    for (uint8_t k = 0; k < pixels; k++) {
        step(2000, negative);
        step(2000, negative);
        position += negative ? -2 : 2;
        feed_mark_here(&feed, false, (int16_t)position);
        if (k == 0) {
            release();
        } else {
            consume();
        }
    }
    feed_end(&feed);
    consume();
}

static void records_of_a_short_line(void)
{
    run_pixels(4, true);
    TEST_ASSERT_EQUAL_UINT8(4, ledger.records.count);
    for (uint8_t i = 0; i < 4; i++) {
        TEST_ASSERT_EQUAL_UINT16(i + 1u, records_get(&ledger.records, i).pixel);
        TEST_ASSERT_EQUAL_INT32(-2 * (i + 1),
                                records_get(&ledger.records, i).expected_steps);
        TEST_ASSERT_EQUAL_INT32(-2 * (i + 1),
                                records_get(&ledger.records, i).actual_steps);
    }
}

static void records_wrap(void)
{
    run_pixels(RECORDS_KEPT + 3u, false);
    TEST_ASSERT_EQUAL_UINT8(RECORDS_KEPT, ledger.records.count);
    TEST_ASSERT_EQUAL_UINT8(2, ledger.records.newest);
    TEST_ASSERT_EQUAL_UINT16(RECORDS_KEPT + 3u, ledger.records.made);
    TEST_ASSERT_EQUAL_UINT32(RECORDS_KEPT + 3u, ledger.pixel);
    struct pixel_record newest = records_get(&ledger.records, RECORDS_KEPT - 1u);
    TEST_ASSERT_EQUAL_UINT16(RECORDS_KEPT + 3u, newest.pixel);
    TEST_ASSERT_EQUAL_UINT16(4, records_get(&ledger.records, 0).pixel);
    TEST_ASSERT_EQUAL_INT32(2L * (int32_t)(RECORDS_KEPT + 3u), newest.actual_steps);
}

static void next_line_counts_from_its_start(void)
{
    run_pixels(3, false);
    run_pixels(2, false);
    TEST_ASSERT_EQUAL_INT32(10, ledger.position_steps);
    TEST_ASSERT_EQUAL_INT32(6, ledger.line_origin);
    TEST_ASSERT_EQUAL_UINT8(2, ledger.records.count);
    TEST_ASSERT_EQUAL_INT32(4, records_get(&ledger.records, 1).actual_steps);
}

static void edge_error_finds_its_record(void)
{
    run_pixels(RECORDS_KEPT + 3u, false);
    records_note_error(&ledger.records, 5, -7);
    records_note_error(&ledger.records, 3, 9);
    // The oldest record is pixel 4's; pixel 3's is no longer kept.
    TEST_ASSERT_EQUAL_INT16(-7, records_get(&ledger.records, 1).edge_error_ticks);
    for (uint8_t i = 0; i < RECORDS_KEPT; i++) {
        TEST_ASSERT_TRUE(i == 1 || records_get(&ledger.records, i).edge_error_ticks == 0);
    }
}

static void restart_keeps_position_and_records(void)
{
    run_pixels(3, false);
    ledger_restart(&ledger, STEP_IDLE_TICKS);
    TEST_ASSERT_EQUAL_INT32(6, ledger.position_steps);
    TEST_ASSERT_EQUAL_UINT8(3, ledger.records.count);
    TEST_ASSERT_EQUAL_UINT32(8192, ledger.loaded_ticks);
}

static void skipped_entries_do_not_count(void)
{
    begin_line();
    for (uint8_t i = 0; i < 10; i++) {
        step(500, false);
    }
    release();
    load_periods(DELAY_PERIODS + 3u);
    advance();
    ring.high[engine.tail] = STEP_HIGH_EMPTY;
    load_periods(3);
    advance();
    ledger_cut(&ledger, &feed.stream);
    feed_reset(&feed, engine.tail, false, ledger.loaded_ticks);
    advance();
    TEST_ASSERT_EQUAL_INT32(3, ledger.position_steps);
    TEST_ASSERT_EQUAL_UINT32(now_ticks, ledger.loaded_ticks);
}

static void ring_wraps_many_times(void)
{
    for (uint8_t i = 0; i < 20; i++) {
        run_pixels(60, (i & 1u) != 0);
    }
    TEST_ASSERT_EQUAL_INT32(0, ledger.position_steps);
    TEST_ASSERT_EQUAL_UINT32(now_ticks, ledger.loaded_ticks);
    TEST_ASSERT_EQUAL_UINT32(60, ledger.pixel);
}

// The waypoint at its end has no place yet: who does not need the middle of the pixel waits for it.
static void the_pixel_written_last_stays_whole(void)
{
    begin_line();
    step(500, false);
    release();
    step(500, false);
    feed_mark_here(&feed, false, 1);
    uint8_t slot = feed.stream.head;

    for (uint8_t i = 0; i < 4; i++) {
        ring.low[(uint8_t)(slot + i)] = 199;
        ring.high[(uint8_t)(slot + i)] = 0;
    }
    stream_put_pixel(&feed.stream, 4, 800, 200, 5);
    while (engine.tail != (uint8_t)(slot + 3u)) {
        load_periods(1);
    }
    struct engine_sample sample = step_engine_sample(&engine);

    ledger_advance(&ledger, &feed.stream, &sample, LEDGER_BY_WAYPOINTS);
    TEST_ASSERT_EQUAL_UINT8(slot + 1u, feed.stream.retired);
    TEST_ASSERT_EQUAL_UINT32(1, ledger.pixel);
    TEST_ASSERT_EQUAL_UINT32(now_ticks - 400u, ledger.loaded_ticks);
    advance();
    TEST_ASSERT_EQUAL_UINT8(slot + 3u, feed.stream.retired);
    TEST_ASSERT_EQUAL_UINT32(now_ticks, ledger.loaded_ticks);
}

// An edge that came before its pixel was passed: its error is another than the one that was kept
// last, whichever of its bytes tells.
static void check_early_error(int16_t shown, int16_t error, uint16_t made)
{
    struct records *records = &ledger.records;

    records_thin(1000, 3);
    records_reset(records);
    records->shown_ticks = shown;
    ledger.pixel = 4;
    records_note_early(records, 5, error);
    ledger_pass_edge(&ledger, 70, 70);
    TEST_ASSERT_EQUAL_UINT16(made, records->made);
    TEST_ASSERT_EQUAL_INT16(error, records->kept[records->newest].edge_error_ticks);
    TEST_ASSERT_EQUAL_INT16(made != 0 ? error : shown, records->shown_ticks);
}

static void early_errors_are_compared_with_the_one_before(void)
{
    check_early_error(0x110, 0x120, 1);
    check_early_error(0x110, 0x210, 1);
    check_early_error(0x110, 0x110, 0);
    check_early_error(0x110, 0x113, 0);
    check_early_error(0x110, 0x114, 1);
    check_early_error(-0x110, -0x120, 1);
    check_early_error(-3, 0x120, 1);
    check_early_error(0x120, -3, 1);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(time_begins_with_two_periods);
    RUN_TEST(idle_periods_pass);
    RUN_TEST(idle_count_wraps);
    RUN_TEST(steps_count_in_their_direction);
    RUN_TEST(position_is_what_was_loaded);
    RUN_TEST(starts_of_the_last_three_periods);
    RUN_TEST(a_capture_is_placed_in_a_period_that_is_long_enough);
    RUN_TEST(idle_after_entries);
    RUN_TEST(mark_waits_for_the_step_before_it);
    RUN_TEST(records_of_a_short_line);
    RUN_TEST(records_wrap);
    RUN_TEST(next_line_counts_from_its_start);
    RUN_TEST(edge_error_finds_its_record);
    RUN_TEST(restart_keeps_position_and_records);
    RUN_TEST(skipped_entries_do_not_count);
    RUN_TEST(ring_wraps_many_times);
    RUN_TEST(the_pixel_written_last_stays_whole);
    RUN_TEST(early_errors_are_compared_with_the_one_before);
    return UNITY_END();
}
