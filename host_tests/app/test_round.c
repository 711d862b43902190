// SPDX-License-Identifier: MIT
// A round of the main loop is short: what it decodes is bounded, whatever waits. Counted in entries
// of the rings; no time passes between the rounds, so nothing is taken from them.
#include <stdint.h>

#include "app/axes/reference.h"
#include "app/bus/bus_port.h"
#include "app/round.h"
#include "axis/decode.h"
#include "fakes/board.h"
#include "fakes/board_bench.h"
#include "hal/step_timer.h"
#include "unity.h"

#define AT_ONCE    120u           // steps of one axis before the choice is made anew,
#define TWICE      (2u * AT_ONCE) //   so many in two turns,
#define STARTING   60u            //   and while an axis is about to be released: a batch
#define SLOW_STEP  8u             // what a step of a slow curve counts, at least
#define STEEP_STEP 4u
// With so long sections of the main loop a round has time for one call of the decoder.
#define SECTION_TICKS (CONFIG_TIMER_HZ / 1000u * 4u)
#define ROOM_FOR      (STEP_RING_CAPACITY - 63u) // entries: a ring is full enough then
#define SERVED        (CONFIG_AXES < 4u ? CONFIG_AXES : 4u) // axes in a round
#define CLOCK_HZ      4000u
#define CLOCK_TICKS   (CONFIG_TIMER_HZ / CLOCK_HZ)
#define SINGLE_STEP 312 // a pixel of 160000 ticks: 512.8 ticks a step make no pulse train

static uint8_t heads[CONFIG_AXES];

void setUp(void)
{
    bench_power_on();
}

void tearDown(void)
{
}

static void slow_pixels(void)
{
    bench_settings()->pixel_hz_num[1] = BENCH_SLOW_HZ;
    limits_apply_settings();
    fake_pixel_clock(5000, BENCH_SLOW_HZ, 1);
    bench_rounds(20);
}

static void arm(uint16_t mask)
{
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(mask, COMMAND_ARM));
}

static void arm_all(void)
{
    arm((1u << CONFIG_AXES) - 1u);
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        heads[i] = axes_get(i)->feed.stream.head;
    }
}

// Entries that axis i got since the last call.
static uint8_t got(uint8_t i)
{
    uint8_t entries = (uint8_t)(axes_get(i)->feed.stream.head - heads[i]);

    heads[i] = axes_get(i)->feed.stream.head;
    return entries;
}

// What a round decodes, altogether; no axis more than `most`.
static uint16_t round_of(uint8_t most, uint8_t *served)
{
    uint16_t entries = 0;

    *served = 0;
    round_poll();
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        uint8_t mine = got(i);
        TEST_ASSERT_TRUE(mine <= most);
        entries = (uint16_t)(entries + mine);
        *served = (uint8_t)(*served + (mine != 0));
    }
    return entries;
}

static uint16_t larger(uint16_t one, uint16_t other)
{
    return one > other ? one : other;
}

// Single steps count little: a round has time for as many as the rings hold, and no more.
static void single_steps_fill_the_rings_in_a_round(void)
{
    uint8_t served = 0;

    slow_pixels();
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        bench_plain_line(i, SINGLE_STEP, 20);
    }
    arm_all();
    (void)round_of(STEP_RING_CAPACITY, &served);
    TEST_ASSERT_EQUAL_UINT8(SERVED, served);
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        TEST_ASSERT_TRUE(axis_ring_fill(axes_get(i)) >= ROOM_FOR);
    }
    TEST_ASSERT_EQUAL_UINT16(0, round_of(0, &served));
}

// A single axis gets the budget part by part, until its ring is full.
static void one_axis_alone_fills_its_ring(void)
{
    uint8_t served = 0;

    slow_pixels();
    bench_plain_line(BENCH_THIRD, SINGLE_STEP, 20);
    arm(BENCH_MASK_OF(BENCH_THIRD));
    heads[BENCH_THIRD] = axes_get(BENCH_THIRD)->feed.stream.head;
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        (void)got(i);
    }
    TEST_ASSERT_TRUE(round_of(STEP_RING_CAPACITY, &served) > AT_ONCE);
    TEST_ASSERT_EQUAL_UINT16(0, round_of(0, &served));
}

static void slow_line(uint8_t axis)
{
    TEST_ASSERT_EQUAL(
        MODBUS_OK,
        bench_entry(axis, LINE_MARK_START | LINE_START_WAIT | LINE_START_SMOOTH, 0));
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_entry(axis, 0, 0));
    for (int16_t count = 1; count <= 5; count = (int16_t)(count + 2)) {
        TEST_ASSERT_EQUAL(MODBUS_OK, bench_entry(axis, count, 1));
    }
    for (int16_t count = 5; count >= 1; count = (int16_t)(count - 2)) {
        TEST_ASSERT_EQUAL(MODBUS_OK, bench_entry(axis, count, 1));
    }
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_entry(axis, LINE_MARK_END, 0));
}

// For each axis some calls of the decoder make some entries, and each at most so many.
static void check_calls(uint8_t most)
{
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        uint8_t entries = 0;

        for (uint8_t calls = 0; calls < 4; calls++) {
            (void)decode_axis(axes_get(i), reference_pixel(), AT_ONCE);
            uint8_t mine = got(i);
            TEST_ASSERT_LESS_OR_EQUAL_UINT8(most, mine);
            entries = (uint8_t)(entries + mine);
        }
        TEST_ASSERT_NOT_EQUAL(0, entries);
    }
}

// A curved pixel of a few steps costs as much of the processor as many others.
static void slow_steps_count_more(void)
{
    bench_rounds(20);
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        slow_line(i);
    }
    arm_all();
    check_calls(AT_ONCE / SLOW_STEP);
}

// From rest to 20000 steps/s in a pixel: each of these steps counts four times.
static void steep_steps_count_more_too(void)
{
    slow_pixels();
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        TEST_ASSERT_EQUAL(
            MODBUS_OK,
            bench_entry(i, LINE_MARK_START | LINE_START_WAIT | LINE_START_SMOOTH, 0));
        TEST_ASSERT_EQUAL(MODBUS_OK, bench_entry(i, 0, 0));
        TEST_ASSERT_EQUAL(MODBUS_OK, bench_entry(i, 100, 1));
        TEST_ASSERT_EQUAL(MODBUS_OK, bench_entry(i, 150, 1));
        TEST_ASSERT_EQUAL(MODBUS_OK, bench_entry(i, 50, 1));
        TEST_ASSERT_EQUAL(MODBUS_OK, bench_entry(i, LINE_MARK_END, 0));
    }
    arm_all();
    check_calls(AT_ONCE / STEEP_STEP);
}

// However much may be decoded: a round ends when its time is over.
static void a_round_ends_by_time(void)
{
    uint8_t served = 0;

    slow_pixels();
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        bench_plain_line(i, SINGLE_STEP, 20);
    }
    arm_all();
    fake_slow_sections(SECTION_TICKS);
    (void)round_of(STEP_RING_CAPACITY, &served);
    TEST_ASSERT_EQUAL_UINT8(1, served);
    (void)round_of(STEP_RING_CAPACITY, &served);
    TEST_ASSERT_EQUAL_UINT8(1, served);
}

#if CONFIG_AXES > 2
// In the middle of a request fewer axes are served than there is time for.
static void a_brief_round_leaves_axes_for_the_next(void)
{
    uint8_t served = 0;

    slow_pixels();
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        bench_plain_line(i, SINGLE_STEP, 20);
    }
    arm_all();
    round_poll_briefly();
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        served = (uint8_t)(served + (got(i) != 0));
    }
    TEST_ASSERT_EQUAL_UINT8(2, served);
    (void)round_of(STEP_RING_CAPACITY, &served);
    TEST_ASSERT_EQUAL_UINT8(CONFIG_AXES - 2u, served);
}

static uint8_t served_briefly(void)
{
    uint8_t served = 0;

    round_poll_briefly();
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        served = (uint8_t)(served + (got(i) != 0));
    }
    return served;
}

// In the middle of a request nothing is decoded for rings that last, although there is room: some
// 8 ms fill them.
static void a_brief_round_leaves_rings_that_last(void)
{
    slow_pixels();
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        bench_plain_line(i, SINGLE_STEP, 20);
    }
    arm_all();
    TEST_ASSERT_TRUE(bench_until(0, AXIS_RUNNING));
    bench_rounds(200);
    (void)served_briefly();
    fake_pass(3u * BENCH_TICKS_PER_MS / 2u);
    TEST_ASSERT_EQUAL_UINT8(0, served_briefly());
    fake_pass(3u * BENCH_TICKS_PER_MS);
    TEST_ASSERT_EQUAL_UINT8(2, served_briefly());
}
#endif

// A block of line data for this board, all there but for its checksum, and a silence behind it.
static void block_waits(void)
{
    static const uint8_t request[] = {7, 16, 0x10, 0, 0, 3, 6, 0, 0, 2, 0, 0x38, 0x38};

    bus_port_start();
    fake_receive(request, sizeof request);
    fake_pass((uint32_t)fake_line.silence_counts * 256u + 256u);
    TEST_ASSERT_TRUE(bus_port_brings_data());
}

// Where lines need more entries and the bus brings some, a round leaves axes for the next one.
static void line_data_ends_a_round_of_lines_that_need_it(void)
{
    uint8_t served = 0;

    slow_pixels();
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        (void)bench_long_start(i);
    }
    arm_all();
    block_waits();
    TEST_ASSERT_TRUE(round_of(TWICE, &served) != 0);
    TEST_ASSERT_EQUAL_UINT8(2, served);
}

static void line_data_waits_for_lines_that_are_whole(void)
{
    uint8_t served = 0;

    slow_pixels();
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        bench_plain_line(i, SINGLE_STEP, 20);
    }
    arm_all();
    block_waits();
    (void)round_of(STEP_RING_CAPACITY, &served);
    TEST_ASSERT_EQUAL_UINT8(SERVED, served);
}

// Trains of several axes end together: none waits for another round.
static void every_axis_has_a_turn(void)
{
    uint8_t served = 0;

    slow_pixels();
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        bench_plain_line(i, 4, 5);
    }
    arm_all();
    (void)round_of(AT_ONCE, &served);
    TEST_ASSERT_EQUAL_UINT8(CONFIG_AXES, served);
    (void)round_of(AT_ONCE, &served);
    TEST_ASSERT_EQUAL_UINT8(0, served);
}

// One round. True if the interrupt of the first axis, whose decoder waited for a train, had come to
// the newer one of two; the older one then has to be free, or in use again.
static bool train_ended(void)
{
    const struct axis *axis = axes_get(0);
    const struct stream *stream = &axis->feed.stream;
    uint8_t newest = stream->newest_train;
    struct engine_sample sample;

    fake_pass(BENCH_ROUND_TICKS);
    step_timer_sample(0, &sample);
    bool ended = axis_awaits_train(axis) && !stream_train_free(stream) &&
                 sample.left != 0 && sample.train == newest;
    round_poll();
    TEST_ASSERT_TRUE(!ended || stream_train_free(stream) ||
                     stream->newest_train != newest);
    return ended;
}

// The decoder waits for one of two trains: in the round behind the end of one the account frees
// that train, and the next pixel is decoded into it. The first axis begins its trains at a pixel's
// edge.
static void the_end_of_a_train_is_seen_at_once(void)
{
    uint16_t ends = 0;

    slow_pixels();
    bench_plain_line(0, 300, 20);
    arm(BENCH_MASK_OF(0));
    TEST_ASSERT_TRUE(bench_until(0, AXIS_RUNNING));
    while (axes_get(0)->life.state == AXIS_RUNNING) {
        ends = (uint16_t)(ends + (train_ended() ? 1u : 0u));
    }
    TEST_ASSERT_EQUAL(AXIS_DONE, axes_get(0)->life.state);
    TEST_ASSERT_TRUE(ends > 15);
}

// The moment of a release must not be missed, even if another axis has much to decode.
static void a_start_keeps_rounds_shorter_still(void)
{
    uint16_t most = 0;

    slow_pixels();
    bench_plain_line(1, SINGLE_STEP, 60);
    arm(2);
    TEST_ASSERT_TRUE(bench_until(1, AXIS_RUNNING));
    bench_rounds(200);
    bench_plain_line(0, 10, 3);
    arm(1);
    while (fake_next_edge_ticks() - fake_now_ticks() > 2u * BENCH_ROUND_TICKS) {
        bench_rounds(1);
    }
    // The edge that starts it is seen late: 78 steps of the other axis later.
    fake_pass(fake_next_edge_ticks() + 40000u - fake_now_ticks());
    TEST_ASSERT_EQUAL_HEX8(0, bench_axes_in(AXIS_STARTING));
    (void)got(1);
    for (uint8_t i = 0; i < 6; i++) {
        round_poll();
        most = larger(most, got(1));
    }
    TEST_ASSERT_EQUAL_HEX8(1, bench_axes_in(AXIS_STARTING));
    TEST_ASSERT_EQUAL_UINT16(STARTING, most);
    TEST_ASSERT_TRUE(bench_until(0, AXIS_DONE));
    TEST_ASSERT_EQUAL(FAULT_none, faults_record()->code);
}

static uint8_t behind(uint8_t i)
{
    return (uint8_t)(step_timer_tail(i) - axes_get(i)->feed.stream.retired);
}

// What is left behind by a round in which it is not the axis's turn.
static uint8_t left_behind(uint8_t entries)
{
    setUp();
    slow_pixels();
    bench_plain_line(1, SINGLE_STEP, 20);
    arm(2);
    TEST_ASSERT_TRUE(bench_until(1, AXIS_RUNNING));
    bench_rounds(100);
    // The next rounds are no axis's turn.
    round_start();
    bench_rounds(1);
    TEST_ASSERT_TRUE(axes_advance(1, LEDGER_EXACTLY));
    while (behind(1) < entries) {
        fake_pass(256);
    }
    axes_get(1)->phase = DECODE_OUTSIDE; // nothing more to decode
    round_poll();
    return behind(1);
}

// The account may lag 64 entries, not one more, whose turn it is or not.
static void an_axis_far_behind_is_followed_out_of_turn(void)
{
    for (uint8_t entries = 60; entries < 64; entries++) {
        TEST_ASSERT_EQUAL_UINT8(entries, left_behind(entries));
    }
    // Blocks are taken as a whole: what is left of one may stay.
    for (uint8_t entries = 64; entries < 90; entries++) {
        TEST_ASSERT_TRUE(left_behind(entries) < 60);
    }
}

// A clock edge that comes before every ring is full is ignored for all axes.
static void no_axis_starts_before_every_ring_is_full(void)
{
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(7, COMMAND_ENABLE));
    slow_pixels();
    bench_rounds(1000); // the drivers have settled
    for (uint8_t i = 0; i < 3; i++) {
        bench_plain_line(i, i == 0 ? 1 : SINGLE_STEP, 20);
    }
    arm(1);
    for (uint8_t i = 0; i < 8; i++) {
        round_poll();
    }
    TEST_ASSERT_TRUE(decode_is_ahead(axes_get(0)));
    fake_pass(fake_next_edge_ticks() + 100u - fake_now_ticks());
    arm(6);       // not the clock's axis, whose account would pass the edge
    round_poll(); // takes the edge
    TEST_ASSERT_EQUAL_HEX8(0, bench_axes_in(AXIS_STARTING));
    for (uint8_t i = 0; i < 8; i++) {
        round_poll();
    }
    fake_pass(fake_next_edge_ticks() + 100u - fake_now_ticks());
    round_poll();
    TEST_ASSERT_EQUAL_HEX8(7, bench_axes_in(AXIS_STARTING));
}

// Arm all axes, and let some time pass in the middle of each round's first release.
static void release_slowly(uint32_t ticks)
{
    bench_settings()->pixel_hz_num[1] = CLOCK_HZ;
    limits_apply_settings();
    fake_pixel_clock(5000, CLOCK_HZ, 1);
    bench_rounds(20);
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        bench_plain_line(i, 2, 20);
    }
    arm_all();
    for (uint16_t left = 2000; bench_axes_in(AXIS_RUNNING) == 0 && left != 0; left--) {
        fake_slow_publish(ticks);
        bench_rounds(1);
    }
}

// At kilohertz an edge of the clock may come in the middle of a release: the clock's axis, whose
// account must come to that edge first, is released in the same round all the same.
static void an_edge_does_not_hold_up_a_release(void)
{
    for (uint32_t ticks = 0; ticks <= 3u * CLOCK_TICKS; ticks += CLOCK_TICKS / 2u) {
        setUp();
        release_slowly(ticks);
        TEST_ASSERT_EQUAL_HEX8((1u << CONFIG_AXES) - 1u, bench_axes_in(AXIS_RUNNING));
    }
}

// All axes cross a pixel edge together, but no two pulse trains may begin at once.
static void trains_begin_two_steps_apart(void)
{
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        TEST_ASSERT_EQUAL_UINT8(2u * i, axis_stagger(axes_get(i)));
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(single_steps_fill_the_rings_in_a_round);
    RUN_TEST(one_axis_alone_fills_its_ring);
    RUN_TEST(slow_steps_count_more);
    RUN_TEST(steep_steps_count_more_too);
    RUN_TEST(a_round_ends_by_time);
#if CONFIG_AXES > 2
    RUN_TEST(a_brief_round_leaves_axes_for_the_next);
    RUN_TEST(a_brief_round_leaves_rings_that_last);
#endif
    RUN_TEST(line_data_ends_a_round_of_lines_that_need_it);
    RUN_TEST(line_data_waits_for_lines_that_are_whole);
    RUN_TEST(every_axis_has_a_turn);
    RUN_TEST(the_end_of_a_train_is_seen_at_once);
    RUN_TEST(a_start_keeps_rounds_shorter_still);
    RUN_TEST(an_axis_far_behind_is_followed_out_of_turn);
    // The clock's axis and two others.
    if (CONFIG_AXES > 2) {
        RUN_TEST(no_axis_starts_before_every_ring_is_full);
    }
    RUN_TEST(an_edge_does_not_hold_up_a_release);
    RUN_TEST(trains_begin_two_steps_apart);
    return UNITY_END();
}
