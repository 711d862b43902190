// SPDX-License-Identifier: MIT
// Intervals in, timer periods out: where STEP edges and direction changes fall when the
// virtual step interrupt consumes the ring.
#include <stdbool.h>
#include <stdint.h>

#include "fakes/chance.h"
#include "fakes/promise.h"
#include "ring/step_engine.h"
#include "stream/feed.h"
#include "unity.h"

#define DELAY_TICKS 2000u
// What feed.c promises for a period beside a command that it cut itself.
#define CUT_MIN_TICKS (STEP_PERIOD_MAX_TICKS - 0x8000u)
#define STEPS_MAX     80u

static struct step_ring ring;
static struct step_engine engine;
static struct feed feed;
static uint32_t now_ticks;                 // start of the period that is loaded next
static uint32_t before_ticks;              // start of the period loaded last,
static bool before_pulse;                  //   and whether it pulses
static uint32_t edge_ticks[STEPS_MAX];     // STEP edges, from the first period on
static uint32_t reversal_ticks[STEPS_MAX]; // direction changes
static uint8_t edges;
static uint8_t reversals;

void setUp(void)
{
    chance_seed(0x5EED0004uL);
    promise_broken = 0;
    feed.reversal_ticks = 0;
    engine.negative = false;
    step_engine_reset(&engine, &ring);
    feed.stream.ring = &ring;
    feed_reset(&feed, 0, false, 0);
    now_ticks = STEP_IDLE_TICKS;
    before_ticks = 0;
    before_pulse = false;
    edges = 0;
    reversals = 0;
}

void tearDown(void)
{
    TEST_ASSERT_EQUAL_UINT16(0, promise_broken);
}

// The interrupt runs at the start of the period loaded before: there the direction
// changes.
static uint32_t load_period(void)
{
    struct step_load load = step_engine_next(&engine, &ring);
    uint32_t length_ticks = (uint32_t)load.top_ticks + 1u;

    if (load.reverses) {
        TEST_ASSERT_FALSE(before_pulse);
        reversal_ticks[reversals] = before_ticks;
        reversals++;
    }
    if (load.pulse) {
        edge_ticks[edges] = now_ticks;
        edges++;
    }
    before_ticks = now_ticks;
    before_pulse = load.pulse;
    now_ticks += length_ticks;
    return length_ticks;
}

static void consume(void)
{
    while (engine.tail != feed.stream.head) {
        TEST_ASSERT_TRUE(load_period() <= STEP_PERIOD_MAX_TICKS);
    }
}

static void pump(void)
{
    while (feed_busy(&feed)) {
        feed_pump(&feed);
    }
}

static void step(uint32_t ticks, bool negative)
{
    feed_step(&feed, ticks, negative);
    pump();
}

// Line zero: DELAY_TICKS after the next period's start.
static uint32_t release(void)
{
    uint32_t zero_ticks = now_ticks + DELAY_TICKS;

    feed_release(&feed, feed.lead_in_ticks + DELAY_TICKS);
    return zero_ticks;
}

static void steps_fall_where_they_should(void)
{
    uint32_t zero = 0;

    feed_hold(&feed);
    for (uint8_t i = 0; i < 5; i++) {
        step(500, false);
    }
    feed_end(&feed);
    (void)load_period();
    TEST_ASSERT_EQUAL_UINT16(1, engine.idle_count);
    zero = release();
    consume();
    TEST_ASSERT_EQUAL_UINT8(5, edges);
    for (uint8_t i = 0; i < 5; i++) {
        TEST_ASSERT_EQUAL_UINT32(zero + 500uL * (i + 1u), edge_ticks[i]);
    }
    TEST_ASSERT_EQUAL_UINT8(0, reversals);
    TEST_ASSERT_EQUAL(STEP_ENGINE_IDLE, engine.state);
}

static void held_line_is_invisible(void)
{
    feed_hold(&feed);
    step(500, false);
    step(500, false);
    for (uint8_t i = 0; i < 10; i++) {
        TEST_ASSERT_EQUAL_UINT32(STEP_IDLE_TICKS, load_period());
    }
    TEST_ASSERT_EQUAL_UINT8(0, engine.tail);
    TEST_ASSERT_EQUAL_UINT8(0, edges);
}

static void short_first_interval_goes_into_the_delay(void)
{
    feed_hold(&feed);
    step(0x7000, false);
    TEST_ASSERT_EQUAL_UINT32(0x7000, feed.lead_in_ticks);
    uint32_t zero = release();
    step(500, false);
    consume();
    TEST_ASSERT_EQUAL_UINT32(zero + 0x7000u, edge_ticks[0]);
}

static void long_first_interval_stays(void)
{
    feed_hold(&feed);
    step(0x7001, false);
    TEST_ASSERT_EQUAL_UINT32(0, feed.lead_in_ticks);
    uint32_t zero = release();
    step(500, false);
    consume();
    TEST_ASSERT_EQUAL_UINT32(zero + 0x7001u, edge_ticks[0]);
}

static void quiet_time_comes_before_the_first_step(void)
{
    feed_hold(&feed);
    feed_quiet(&feed, 400000uL);
    pump();
    uint32_t zero = release();
    step(300, false);
    step(500, false);
    consume();
    TEST_ASSERT_EQUAL_UINT32(zero + 400300uL, edge_ticks[0]);
}

// The pulse is in the first chunk, none is longer than a period or, at the end, too short
// for the commands around it.
static uint32_t shortest_period(void)
{
    uint32_t shortest = UINT32_MAX;

    while (edges < 2) {
        uint32_t length = load_period();
        // The period of the second step no longer belongs to the interval.
        shortest = edges == 1 && length < shortest ? length : shortest;
    }
    return shortest;
}

static void check_cut(uint32_t interval)
{
    setUp();
    feed_hold(&feed);
    step(500, false);
    uint32_t zero = release();
    step(interval, false);
    step(500, false);
    uint32_t shortest = shortest_period();
    TEST_ASSERT_EQUAL_UINT32(zero + 500u + interval, edge_ticks[1]);
    if (interval > STEP_PERIOD_MAX_TICKS) {
        TEST_ASSERT_TRUE(shortest >= CUT_MIN_TICKS);
    }
}

static void long_intervals_are_cut(void)
{
    check_cut(STEP_PERIOD_MAX_TICKS);
    check_cut(STEP_PERIOD_MAX_TICKS + 1uL);
    check_cut(2uL * STEP_PERIOD_MAX_TICKS);
    check_cut(0x8000uL + STEP_PERIOD_MAX_TICKS);
    check_cut(0x8001uL + STEP_PERIOD_MAX_TICKS);
    check_cut(533333uL);
    check_cut(4000000uL);
}

static uint8_t entries_of(uint32_t interval)
{
    setUp();
    feed_hold(&feed);
    step(500, false);
    (void)release();
    uint8_t head = feed.stream.head;
    step(interval, false);
    step(500, false);
    return (uint8_t)(feed.stream.head - head);
}

// A longer period would read as a pulse train or a command.
static void longest_interval_that_is_one_period(void)
{
    TEST_ASSERT_EQUAL_UINT8(entries_of(500), entries_of(0xFD00));
    TEST_ASSERT_TRUE(entries_of(0xFD00) < entries_of(0xFD01));
}

static void check_reversal_between(uint32_t interval)
{
    setUp();
    feed_hold(&feed);
    step(2000, false);
    (void)release();
    step(interval, true);
    step(2000, true);
    consume();
    TEST_ASSERT_EQUAL_UINT8(2, edges);
    TEST_ASSERT_EQUAL_UINT8(1, reversals);
    TEST_ASSERT_EQUAL_UINT32(interval, edge_ticks[1] - edge_ticks[0]);
    TEST_ASSERT_TRUE(reversal_ticks[0] - edge_ticks[0] >= 832u);
    TEST_ASSERT_TRUE(edge_ticks[1] - reversal_ticks[0] >= 832u);
    if (interval <= STEP_PERIOD_MAX_TICKS) {
        TEST_ASSERT_EQUAL_UINT32(edge_ticks[0] + interval / 2u, reversal_ticks[0]);
    }
}

static void direction_changes_inside_the_interval(void)
{
    check_reversal_between(1664);
    check_reversal_between(1665);
    check_reversal_between(40000uL);
    check_reversal_between(STEP_PERIOD_MAX_TICKS);
    check_reversal_between(STEP_PERIOD_MAX_TICKS + 1uL);
    check_reversal_between(100000uL);
    check_reversal_between(1000000uL);
}

// Zero pixels fill the waypoints between two steps that go opposite ways: the direction has its
// hold and set-up time on both sides, whether their time is written early or not.
static void check_reversal_behind_zero_pixels(uint16_t needed_ticks, bool written_early)
{
    const uint32_t pixel_ticks = 1500;
    uint32_t interval = 0;

    setUp();
    feed.reversal_ticks = needed_ticks;
    feed_hold(&feed);
    step(2000, false);
    (void)release();
    uint8_t head = feed.stream.head;
    while (!stream_waypoints_full(&feed.stream)) {
        feed_quiet(&feed, pixel_ticks);
        pump();
        feed_mark_here(&feed, false, 0);
        feed_make_room(&feed, false);
        interval += pixel_ticks;
    }
    TEST_ASSERT_EQUAL(written_early, feed.stream.head != head);
    step(pixel_ticks, true);
    interval += pixel_ticks;
    step(2000, true);
    consume();
    TEST_ASSERT_EQUAL_UINT8(1, reversals);
    TEST_ASSERT_EQUAL_UINT32(interval, edge_ticks[1] - edge_ticks[0]);
    TEST_ASSERT_TRUE(reversal_ticks[0] - edge_ticks[0] >= needed_ticks);
    TEST_ASSERT_TRUE(edge_ticks[1] - reversal_ticks[0] >= needed_ticks);
}

static void zero_pixels_leave_a_reversal_its_time(void)
{
    check_reversal_behind_zero_pixels(832, true);
    check_reversal_behind_zero_pixels(2120, true);
    check_reversal_behind_zero_pixels(10000, true);
    check_reversal_behind_zero_pixels(12000, false);
}

#define NEEDED_TICKS 832u // around a reversal

// What is behind a pixel edge must wait for the clock: of the time in front of the edge no more is
// kept than a reversal needs, in no more than a burst of entries.
static void wait_behind(uint32_t quiet_ticks)
{
    setUp();
    feed.reversal_ticks = NEEDED_TICKS;
    feed_hold(&feed);
    step(2000, false);
    (void)release();
    feed_quiet(&feed, quiet_ticks);
    pump();
    feed_mark_here(&feed, false, 0);
    uint8_t head = feed.stream.head;
    feed_make_room(&feed, true);
    TEST_ASSERT_LESS_THAN_UINT32(2u * (NEEDED_TICKS + 1024u), feed.pending_ticks);
    TEST_ASSERT_LESS_OR_EQUAL_UINT8(FEED_BURST, (uint8_t)(feed.stream.head - head));
}

static void check_time_before_a_wait(uint32_t quiet_ticks, bool negative)
{
    wait_behind(quiet_ticks);
    step(100, negative);
    step(2000, negative);
    consume();
    TEST_ASSERT_EQUAL_UINT32(quiet_ticks + 100u, edge_ticks[1] - edge_ticks[0]);
    TEST_ASSERT_EQUAL_UINT8(negative ? 1 : 0, reversals);
}

static void check_reversal_behind_a_wait(uint32_t quiet_ticks)
{
    check_time_before_a_wait(quiet_ticks, true);
    TEST_ASSERT_GREATER_OR_EQUAL_UINT32(NEEDED_TICKS, reversal_ticks[0] - edge_ticks[0]);
    TEST_ASSERT_GREATER_OR_EQUAL_UINT32(NEEDED_TICKS, edge_ticks[1] - reversal_ticks[0]);
}

static void time_before_a_wait_is_written_out(void)
{
    for (uint32_t quiet_ticks = 2000; quiet_ticks < 300000uL; quiet_ticks += 977u) {
        check_time_before_a_wait(quiet_ticks, false);
        check_reversal_behind_a_wait(quiet_ticks);
    }
}

static void first_step_reverses_during_the_delay(void)
{
    feed_hold(&feed);
    step(1000, true);
    step(1000, true);
    uint32_t zero = release();
    consume();
    TEST_ASSERT_EQUAL_UINT8(1, reversals);
    TEST_ASSERT_EQUAL_UINT32(zero + 1000u, edge_ticks[0]);
    TEST_ASSERT_TRUE(reversal_ticks[0] <= zero);
    TEST_ASSERT_TRUE(engine.negative);
}

static void end_gives_the_last_step_a_period(void)
{
    feed_hold(&feed);
    step(700, false);
    uint32_t zero = release();
    feed_end(&feed);
    consume();
    TEST_ASSERT_EQUAL_UINT8(1, edges);
    TEST_ASSERT_EQUAL_UINT32(zero + 700u, edge_ticks[0]);
    TEST_ASSERT_EQUAL_UINT32(zero + 700u + 2uL * STEP_IDLE_TICKS, now_ticks);
    TEST_ASSERT_EQUAL_UINT16(1, engine.idle_count);
    TEST_ASSERT_EQUAL(STEP_ENGINE_IDLE, engine.state);
}

static void end_after_quiet_time_keeps_it(void)
{
    feed_hold(&feed);
    step(700, false);
    uint32_t zero = release();
    feed_quiet(&feed, 50000uL);
    feed_end(&feed);
    consume();
    TEST_ASSERT_EQUAL_UINT32(zero + 50700uL + STEP_IDLE_TICKS, now_ticks);
}

static void next_line_pulses_again(void)
{
    for (uint8_t i = 0; i < 3; i++) {
        feed_hold(&feed);
        step(700, (i & 1u) != 0);
        (void)load_period();
        uint32_t zero = release();
        feed_end(&feed);
        consume();
        TEST_ASSERT_EQUAL_UINT8(i + 1, edges);
        TEST_ASSERT_EQUAL_UINT32(zero + 700u, edge_ticks[i]);
    }
    TEST_ASSERT_EQUAL_UINT8(2, reversals);
}

static void missing_end_halts(void)
{
    feed_hold(&feed);
    step(700, false);
    (void)release();
    step(700, false);
    consume();
    TEST_ASSERT_EQUAL(STEP_ENGINE_IN_LINE, engine.state);
    (void)load_period();
    TEST_ASSERT_EQUAL(STEP_ENGINE_HALTED, engine.state);
}

static void space_counts_from_the_retired_slot(void)
{
    TEST_ASSERT_EQUAL_UINT8(STEP_RING_CAPACITY, stream_space(&feed.stream));
    feed_hold(&feed);
    step(500, false);
    step(500, false);
    TEST_ASSERT_EQUAL_UINT8(STEP_RING_CAPACITY - feed.stream.head,
                            stream_space(&feed.stream));
    feed.stream.retired = feed.stream.head;
    TEST_ASSERT_EQUAL_UINT8(STEP_RING_CAPACITY, stream_space(&feed.stream));
}

static void check_burst(uint8_t head_before)
{
    TEST_ASSERT_TRUE((uint8_t)(feed.stream.head - head_before) <= FEED_BURST);
}

static void step_in_bursts(uint32_t interval, bool negative)
{
    uint8_t head = feed.stream.head;

    feed_step(&feed, interval, negative);
    check_burst(head);
    while (feed_busy(&feed)) {
        head = feed.stream.head;
        feed_pump(&feed);
        check_burst(head);
    }
}

// As the writer does it: commands are never left without the period behind them.
static void consume_behind(void)
{
    while ((uint8_t)(feed.stream.head - engine.tail) > FEED_BURST) {
        TEST_ASSERT_TRUE(load_period() <= STEP_PERIOD_MAX_TICKS);
    }
}

static void no_call_writes_more_than_a_burst(void)
{
    feed_hold(&feed);
    step(700, false);
    (void)release();
    for (uint8_t i = 0; i < 40; i++) {
        step_in_bursts(chance_between(1664, 200000uL), (chance() & 1u) != 0);
        edges = 0;
        reversals = 0;
        consume_behind();
    }
}

static uint32_t random_interval(void)
{
    static const uint32_t longest[] = {6000, 6000, 70000uL, 600000uL};

    return chance_between(1664, longest[chance() & 3u]);
}

static void random_line(void)
{
    static uint32_t places[STEPS_MAX];
    uint8_t wanted_reversals = 0;
    bool negative = false;

    feed_hold(&feed);
    step(1664, false);
    places[0] = release() + 1664u;
    for (uint8_t i = 1; i < STEPS_MAX; i++) {
        uint32_t interval = random_interval();
        bool reverses = (chance() & 3u) == 0;
        negative = negative != reverses;
        wanted_reversals = (uint8_t)(wanted_reversals + reverses);
        step(interval, negative);
        consume_behind();
        places[i] = places[i - 1u] + interval;
    }
    feed_end(&feed);
    consume();
    TEST_ASSERT_EQUAL_UINT8(STEPS_MAX, edges);
    TEST_ASSERT_EQUAL_UINT32_ARRAY(places, edge_ticks, STEPS_MAX);
    TEST_ASSERT_EQUAL_UINT8(wanted_reversals, reversals);
    TEST_ASSERT_EQUAL(negative, engine.negative);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(steps_fall_where_they_should);
    RUN_TEST(held_line_is_invisible);
    RUN_TEST(short_first_interval_goes_into_the_delay);
    RUN_TEST(long_first_interval_stays);
    RUN_TEST(quiet_time_comes_before_the_first_step);
    RUN_TEST(long_intervals_are_cut);
    RUN_TEST(longest_interval_that_is_one_period);
    RUN_TEST(direction_changes_inside_the_interval);
    RUN_TEST(zero_pixels_leave_a_reversal_its_time);
    RUN_TEST(time_before_a_wait_is_written_out);
    RUN_TEST(first_step_reverses_during_the_delay);
    RUN_TEST(end_gives_the_last_step_a_period);
    RUN_TEST(end_after_quiet_time_keeps_it);
    RUN_TEST(next_line_pulses_again);
    RUN_TEST(missing_end_halts);
    RUN_TEST(space_counts_from_the_retired_slot);
    RUN_TEST(no_call_writes_more_than_a_burst);
    RUN_TEST(random_line);
    return UNITY_END();
}
