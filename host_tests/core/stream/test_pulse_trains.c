// SPDX-License-Identifier: MIT
// Pulse trains: evenly spaced steps that the step interrupt makes by itself. Writer, interrupt and
// ledger together are compared with the same steps one by one.
#include <stddef.h>
#include <stdint.h>

#include "account/ledger.h"
#include "fakes/chance.h"
#include "fakes/promise.h"
#include "ring/step_engine.h"
#include "stream/even.h"
#include "stream/feed.h"
#include "unity.h"

#define DELAY_TICKS 1500u
#define EDGE_TICKS  32u  // of a period, ahead of its STEP edge
#define FIRST_TICKS 900u // to the step before a train, on the train's first period

static struct step_ring ring;
static struct step_engine engine;
static struct feed feed;
static struct ledger ledger;
static uint32_t now_ticks;  // end of the newest loaded period,
static uint32_t lengths[4]; //   and the newest ones' lengths, newest first
static bool pulses[4];
static int32_t position_steps; // of the periods loaded

static void open_line(bool negative)
{
    step_engine_reset(&engine, &ring);
    ledger_reset(&ledger, STEP_IDLE_TICKS);
    ledger.negative = negative;
    feed.stream.ring = &ring;
    feed.stream.engine_trains = engine.trains;
    feed_reset(&feed, 0, negative, ledger.loaded_ticks);
    now_ticks = 2uL * STEP_IDLE_TICKS;
    lengths[0] = STEP_IDLE_TICKS;
    lengths[1] = STEP_IDLE_TICKS;
    pulses[0] = false;
    pulses[1] = false;
    position_steps = 0;
    feed_hold(&feed);
    feed_mark_here(&feed, true, 0);
    feed_step(&feed, FIRST_TICKS, negative);
    feed_release(&feed, feed.lead_in_ticks + DELAY_TICKS);
}

void setUp(void)
{
    promise_broken = 0;
    chance_seed(0x5EED0011uL);
    open_line(false);
}

void tearDown(void)
{
    TEST_ASSERT_EQUAL_UINT16(0, promise_broken);
}

static uint32_t load(void)
{
    struct step_load next = step_engine_next(&engine, &ring);
    uint32_t ticks = (uint32_t)next.top_ticks + 1u;

    for (uint8_t i = 3; i != 0; i--) {
        lengths[i] = lengths[i - 1u];
        pulses[i] = pulses[i - 1u];
    }
    lengths[0] = ticks;
    pulses[0] = next.pulse;
    now_ticks += ticks;
    if (next.pulse) {
        position_steps += feed.negative ? -1 : 1;
    }
    return ticks;
}

static void advance(void)
{
    struct engine_sample sample = step_engine_sample(&engine);

    ledger_advance(&ledger, &feed.stream, &sample, LEDGER_EXACTLY);
}

// The delay's two periods, and the ledger behind them.
static void pass_delay(void)
{
    (void)load();
    (void)load();
    advance();
}

// A seek asks how many of the newest steps were made behind its switch's edge.
static void check_steps_after(void)
{
    uint32_t span_ticks = lengths[0] + lengths[1] + lengths[2];
    uint32_t ticks = now_ticks - chance_between(0, span_ticks);
    uint32_t start = now_ticks;
    uint8_t steps = 0;

    for (uint8_t back = 0; back < 3u; back++) {
        start -= lengths[back];
        steps = (uint8_t)(steps +
                          (pulses[back] && (int32_t)(start + EDGE_TICKS - ticks) > 0));
    }
    TEST_ASSERT_EQUAL_UINT8(steps,
                            ledger_steps_after(&ledger, &feed.stream, ticks, EDGE_TICKS));
}

static void check_account(void)
{
    uint32_t start = now_ticks;

    advance();
    TEST_ASSERT_EQUAL_INT32(position_steps, ledger_position(&ledger));
    for (uint8_t back = 0; back < 3; back++) {
        start -= lengths[back];
        TEST_ASSERT_EQUAL_UINT32(start, ledger_period_start(&ledger, &feed.stream, back));
    }
    check_steps_after();
}

static struct even random_even(void)
{
    struct even even = {0};
    uint16_t steps = (uint16_t)chance_between(3, 700);
    uint32_t base = chance_between(64, 1000);

    even_start(&even, base * steps + chance_between(0, steps - 1u), steps);
    for (uint32_t i = chance_between(0, steps - 1u); i != 0; i--) {
        (void)even_next(&even);
    }
    return even;
}

static void put_train(struct even *even, uint16_t steps)
{
    (void)feed_train(&feed, even, steps);
}

static void same_periods_as_one_by_one(void)
{
    for (uint8_t i = 0; i < 60; i++) {
        struct even even = random_even();
        struct even expected = even;
        uint16_t steps = (uint16_t)chance_between(3, 600);
        open_line((i & 1u) != 0);
        pass_delay();
        if (!stream_fits_train(&feed.stream, &even)) {
            continue;
        }
        put_train(&even, steps);
        for (uint16_t k = 0; k < steps; k++) {
            TEST_ASSERT_EQUAL_UINT32(even_next(&expected), load());
            if (chance_between(0, 9) == 0) {
                check_account();
            }
        }
        check_account();
        TEST_ASSERT_EQUAL_UINT16(expected.sum, even.sum);
        TEST_ASSERT_EQUAL_UINT8(LEDGER_NO_TRAIN, ledger.train);
        TEST_ASSERT_EQUAL_UINT16(0, feed.stream.trains[0].steps);
        TEST_ASSERT_EQUAL_UINT32(stream_end_ticks(&feed.stream), ledger.loaded_ticks);
    }
}

// One train behind another without a period between them, with both trains and around the ring.
static void train_follows_train(void)
{
    struct even even = {0};

    even_start(&even, 200001, 400);
    struct even expected = even;
    pass_delay();
    put_train(&even, 200);
    for (uint8_t i = 0; i < 90; i++) {
        TEST_ASSERT_TRUE(stream_train_free(&feed.stream));
        put_train(&even, 200);
        TEST_ASSERT_FALSE(stream_train_free(&feed.stream));
        for (uint16_t k = 0; k < 200; k++) {
            TEST_ASSERT_EQUAL_UINT32(even_next(&expected), load());
        }
        check_account();
    }
}

static void entry_is_taken_ahead(void)
{
    struct even even = {0};

    even_start(&even, 100000, 300);
    pass_delay();
    put_train(&even, 130);
    (void)load();
    TEST_ASSERT_EQUAL_INT8(126, engine.left);
    for (uint8_t k = 0; k < 126; k++) {
        (void)load();
    }
    // The second entry's three periods are known before the first of them is due.
    TEST_ASSERT_EQUAL_INT8(3, engine.left);
    TEST_ASSERT_EQUAL_UINT8(feed.stream.head, engine.tail);
}

static bool due(void)
{
    struct engine_sample sample = step_engine_sample(&engine);

    return ledger_due(&ledger, &feed.stream, &sample);
}

// With no pixel edge between them: the writer may be waiting for the first one.
static void train_that_is_over_is_looked_after(void)
{
    struct even even = {0};

    even_start(&even, 200001, 400);
    pass_delay();
    put_train(&even, 150);
    put_train(&even, 150);
    (void)load();
    advance();
    for (uint8_t k = 0; k < 148; k++) {
        (void)load();
    }
    TEST_ASSERT_FALSE(due());
    (void)load();
    TEST_ASSERT_TRUE(due());
    advance();
    TEST_ASSERT_TRUE(stream_train_free(&feed.stream));
}

#define SINGLES_AND_TRAINS ((uint16_t)(22u * STEP_TRAINS - 1u))

static void single_periods_between_trains(void)
{
    struct even even = {0};

    even_start(&even, 100100, 300);
    struct even expected = even;
    pass_delay();
    for (uint8_t i = 0; i < STEP_TRAINS; i++) {
        put_train(&even, 20);
        feed_step(&feed, even_next(&even), false);
        feed_step(&feed, even_next(&even), false);
    }
    for (uint16_t k = 0; k < SINGLES_AND_TRAINS; k++) {
        TEST_ASSERT_EQUAL_UINT32(even_next(&expected), load());
        check_account();
    }
}

// A pixel edge falls on the step that the train's first period carries.
static void edge_inside_the_first_entry(void)
{
    struct even even = {0};

    even_start(&even, 100100, 300);
    pass_delay();
    feed_mark_here(&feed, false, 1);
    put_train(&even, 100);
    check_account();
    TEST_ASSERT_EQUAL_UINT32(0, ledger.pixel);
    (void)load();
    advance();
    TEST_ASSERT_EQUAL_UINT32(1, ledger.pixel);
    TEST_ASSERT_EQUAL_INT32(1, records_get(&ledger.records, 0).actual_steps);
    TEST_ASSERT_EQUAL_INT32(1, records_get(&ledger.records, 0).expected_steps);
}

// A clock edge in the delay before a train, seen when two periods of the train have begun.
static void capture_seen_late_is_of_the_delay(void)
{
    struct even even = {0};

    even_start(&even, 100100, 300);
    pass_delay();
    uint32_t delay_start = ledger_period_start(&ledger, &feed.stream, 0);
    put_train(&even, 100);
    (void)load();
    (void)load();
    advance();
    TEST_ASSERT_EQUAL_UINT32(delay_start + 900u,
                             ledger_capture_ticks(&ledger, &feed.stream, 1, 900));
    // A count that the train's periods reach is taken as it was seen.
    TEST_ASSERT_EQUAL_UINT32(ledger_period_start(&ledger, &feed.stream, 1) + 100u,
                             ledger_capture_ticks(&ledger, &feed.stream, 1, 100));
}

static void edge_seen_late_has_the_same_record(void)
{
    struct even even = {0};

    open_line(true);
    even_start(&even, 100100, 300);
    pass_delay();
    feed_mark_here(&feed, false, -1);
    put_train(&even, 300);
    for (uint16_t k = 0; k < 250; k++) {
        (void)load();
    }
    check_account();
    TEST_ASSERT_EQUAL_UINT32(1, ledger.pixel);
    TEST_ASSERT_EQUAL_INT32(-1, records_get(&ledger.records, 0).actual_steps);
}

static void check_halt(void)
{
    step_engine_halt(&engine);
    step_engine_halt(&engine); // must not undo it
    TEST_ASSERT_TRUE(step_engine_going((enum step_engine_state)engine.state));
}

static void check_at_rest(uint16_t steps)
{
    TEST_ASSERT_EQUAL_INT32(steps, ledger_position(&ledger));
    TEST_ASSERT_EQUAL_UINT8(LEDGER_NO_TRAIN, ledger.train);
    TEST_ASSERT_TRUE(stream_train_free(&feed.stream));
    uint8_t slot = 0;

    (void)step_engine_next(&engine, &ring);
    TEST_ASSERT_TRUE(step_engine_settle(&engine, &ring, &slot));
    TEST_ASSERT_FALSE(step_engine_sample(&engine).cut);
}

static void check_taken_away_after(uint16_t steps)
{
    struct even even = {0};

    even_start(&even, 100100, 300);
    pass_delay();
    put_train(&even, 300);
    for (uint16_t k = 0; k < steps; k++) {
        (void)load();
    }
    check_halt();
    check_account();
    uint32_t before_ticks = now_ticks;
    TEST_ASSERT_EQUAL_UINT32(STEP_IDLE_TICKS, load());
    TEST_ASSERT_EQUAL(STEP_ENGINE_HALTED, engine.state);
    advance();
    TEST_ASSERT_EQUAL_UINT32(before_ticks, ledger_period_start(&ledger, &feed.stream, 0));
    check_at_rest(steps);
}

static void rest_of_a_train_taken_away(void)
{
    static const uint16_t places[] = {1, 2, 3, 126, 127, 150, 299};

    for (size_t i = 0; i < sizeof places / sizeof *places; i++) {
        open_line(false);
        check_taken_away_after(places[i]);
    }
}

// Two pixels of 300 steps. The edge between them is passed with the second one's first step; a halt
// behind that leaves the record of it, and a halt in front of it leaves none.
static void check_record_of_a_halt(uint8_t beyond, bool looked_before)
{
    struct even even = {0};

    open_line(false);
    pass_delay();
    even_start(&even, 100100, 300);
    put_train(&even, 300);
    feed_mark_here(&feed, false, 301);
    even_start(&even, 100100, 300);
    put_train(&even, 300);
    feed_mark_here(&feed, false, 601);
    for (uint16_t k = 0; k < 300u + beyond; k++) {
        (void)load();
    }
    if (looked_before) {
        check_account();
    }
    check_halt();
    check_account();
    (void)load();
    advance();
    TEST_ASSERT_EQUAL_INT32(300 + beyond, ledger_position(&ledger));
    TEST_ASSERT_EQUAL_UINT32(beyond == 0 ? 0u : 1u, ledger.pixel);
    TEST_ASSERT_EQUAL_UINT8(beyond == 0 ? 0 : 1, ledger.records.count);
    if (beyond != 0) {
        struct pixel_record record = records_get(&ledger.records, 0);
        TEST_ASSERT_EQUAL_INT32(301, record.actual_steps);
        TEST_ASSERT_EQUAL_INT32(301, record.expected_steps);
    }
}

static void a_halt_leaves_the_records_of_passed_edges(void)
{
    for (uint8_t beyond = 0; beyond < 130; beyond++) {
        check_record_of_a_halt(beyond, false);
        check_record_of_a_halt(beyond, true);
    }
}

static bool can_carry(uint32_t ticks)
{
    struct even even = {0};

    even_start(&even, ticks, 100);
    return stream_fits_train(&feed.stream, &even);
}

// 512 and 513 ticks: TOP 0x1FF and 0x200
static void what_cannot_be_carried(void)
{
    TEST_ASSERT_FALSE(can_carry(51201));
    TEST_ASSERT_FALSE(can_carry(100uL * STEP_PERIOD_MAX_TICKS + 1u));
}

static void what_can_be_carried(void)
{
    TEST_ASSERT_TRUE(can_carry(51200));
    TEST_ASSERT_TRUE(can_carry(51301));
}

static void nobody_to_carry(void)
{
    feed.stream.engine_trains = NULL;
    TEST_ASSERT_FALSE(can_carry(51301));
}

static void skip_is_as_many_nexts(void)
{
    for (uint8_t i = 0; i < 100; i++) {
        struct even even = random_even();
        struct even skipped = even;
        uint16_t steps = (uint16_t)chance_between(1, even.steps);
        uint32_t ticks = 0;
        for (uint16_t k = 0; k < steps; k++) {
            ticks += even_next(&even);
        }
        TEST_ASSERT_EQUAL_UINT32(ticks, even_skip(&skipped, steps));
        TEST_ASSERT_EQUAL_UINT16(even.sum, skipped.sum);
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(same_periods_as_one_by_one);
    RUN_TEST(train_follows_train);
    RUN_TEST(entry_is_taken_ahead);
    RUN_TEST(train_that_is_over_is_looked_after);
    RUN_TEST(single_periods_between_trains);
    RUN_TEST(edge_inside_the_first_entry);
    RUN_TEST(edge_seen_late_has_the_same_record);
    RUN_TEST(capture_seen_late_is_of_the_delay);
    RUN_TEST(rest_of_a_train_taken_away);
    RUN_TEST(a_halt_leaves_the_records_of_passed_edges);
    RUN_TEST(what_cannot_be_carried);
    RUN_TEST(what_can_be_carried);
    RUN_TEST(nobody_to_carry);
    RUN_TEST(skip_is_as_many_nexts);
    return UNITY_END();
}
