// SPDX-License-Identifier: MIT
// Seeks over the fake board: where they stop, what the switch's edge is worth, how they fail.
#include <stdint.h>

#include "app/round.h"
#include "app/seek.h"
#include "fakes/board.h"
#include "fakes/machine_bench.h"
#include "hal/pixel_clock.h"
#include "hal/switches.h"
#include "nothing_moves.h"
#include "unity.h"
#include "wire/register_map.h"

#define TOP_STEPS    8
#define RAMP_STEPS   7 // 1 + 2 + 4
#define RAMP_PX      3
#define CLOSED       false
#define OPEN         true
#define FILTER_TICKS BENCH_TICKS_PER_MS // by default

void setUp(void)
{
    bench_power_on();
    bench_rounds(20);
}

void tearDown(void)
{
}

static void entry(uint8_t axis, int16_t count, uint16_t repeat)
{
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_entry(axis, count, repeat));
}

// 1 2 4, 8 for so many pixels, 4 2 1; upwards or, with sign -1, downwards.
static void queue_seek(uint8_t axis, uint16_t flags, int16_t sign, uint16_t pixels)
{
    entry(axis, (int16_t)(RUN_MARK_START | RUN_START_SEEK | flags), 0);
    entry(axis, 0, 0);
    for (int16_t count = 1; count < TOP_STEPS; count = (int16_t)(2 * count)) {
        entry(axis, (int16_t)(sign * count), 1);
    }
    entry(axis, (int16_t)(sign * TOP_STEPS), pixels);
    entry(axis, RUN_MARK_DOWN, 0);
    for (int16_t count = TOP_STEPS / 2; count != 0; count = (int16_t)(count / 2)) {
        entry(axis, (int16_t)(sign * count), 1);
    }
    entry(axis, RUN_MARK_END, 0);
}

static void start(uint8_t axis)
{
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command((uint16_t)(1u << axis), COMMAND_ARM));
    TEST_ASSERT_TRUE(bench_until(axis, AXIS_RUNNING));
}

// Rounds until `ticks` after line zero, then as many more ticks as are left.
static void go_to(uint8_t axis, uint32_t ticks)
{
    uint32_t until = axes_get(axis)->zero_ticks + ticks;

    while ((int32_t)(until - fake_now_ticks()) > (int32_t)BENCH_ROUND_TICKS) {
        bench_rounds(1);
    }
    fake_pass(until - fake_now_ticks());
}

// Steps of such a seek at an instant after line zero: the last of each pixel on its end.
static int32_t steps_at(uint32_t ticks)
{
    static const uint16_t places[] = {16000, 24000, 32000, 36000, 40000, 44000, 48000};
    int32_t steps = 0;

    for (uint8_t i = 0; i < 7; i++) {
        steps += places[i] <= ticks;
    }
    if (ticks > 48000u) {
        steps += (int32_t)((ticks - 48000u) / 2000u);
    }
    return steps;
}

static void stops_at(uint8_t axis, int16_t sign, uint32_t ticks)
{
    setUp();
    queue_seek(axis, 0, sign, 200);
    start(axis);
    go_to(axis, ticks);
    uint32_t edge = fake_now_ticks();
    fake_switch(axis, SWITCH_HOME, CLOSED);
    TEST_ASSERT_TRUE(bench_until(axis, AXIS_DONE));
    bench_rounds(10);
    TEST_ASSERT_EQUAL_UINT16(TRIP_CLOSED, bench_input(REG_INPUT_trip_code));
    TEST_ASSERT_EQUAL_UINT16(axis, bench_input(REG_INPUT_trip_axis));
    TEST_ASSERT_EQUAL_UINT32(edge, bench_input_wide(REG_INPUT_trip_ticks));
    TEST_ASSERT_EQUAL_INT32(sign * steps_at(ticks),
                            (int32_t)bench_input_wide(REG_INPUT_trip_position_steps));
    TEST_ASSERT_EQUAL(FAULT_none, faults_record()->code);
}

static void edge_has_its_tick_and_position(void)
{
    static const uint32_t places[] = {100000, 99999, 100001, 101999, 123456, 777777};

    for (uint8_t i = 0; i < (uint8_t)(sizeof places / sizeof places[0]); i++) {
        stops_at(0, 1, places[i]);
        stops_at(0, -1, places[i]);
        stops_at(BENCH_THIRD, 1, places[i]);
        stops_at(BENCH_LAST, -1, places[i]);
    }
}

// Filter, what is decoded ahead and a pixel at most; then the ramp.
static void stop_is_controlled_and_soon(void)
{
    stops_at(0, 1, 400000);
    int32_t late = fake_axes[0].steps - steps_at(400000) - RAMP_STEPS;
    uint32_t most_ticks = FILTER_TICKS + 0x20000u + 3u * BENCH_PIXEL_TICKS;

    TEST_ASSERT_TRUE(late > 0 && (uint32_t)late * 2000u <= most_ticks);
    TEST_ASSERT_EQUAL_INT32(0, (fake_axes[0].steps - 2 * RAMP_STEPS) % TOP_STEPS);
    check_nothing_moves();
}

static void trip_while_speeding_up(void)
{
    stops_at(1, 1, 17000);
    TEST_ASSERT_EQUAL_INT32(1, steps_at(17000));
    TEST_ASSERT_TRUE(fake_axes[1].steps < 200);
}

static void switch_already_closed_makes_no_step(void)
{
    fake_switch(0, SWITCH_HOME, CLOSED);
    bench_rounds(40);
    queue_seek(0, 0, 1, 200);
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(1, COMMAND_ARM));
    TEST_ASSERT_TRUE(bench_until(0, AXIS_DONE));
    bench_rounds(5);
    TEST_ASSERT_EQUAL_UINT16(TRIP_ALREADY, bench_input(REG_INPUT_trip_code));
    TEST_ASSERT_EQUAL(FAULT_none, faults_record()->code);
    TEST_ASSERT_TRUE(fake_axes[0].steps < 200);
    TEST_ASSERT_EQUAL(MODBUS_DEVICE_FAILURE, bench_command(1, COMMAND_ZERO));
}

static void opening_is_sought_too(void)
{
    fake_switch(0, SWITCH_HOME, CLOSED);
    bench_rounds(40);
    queue_seek(0, RUN_START_OPEN, -1, 200);
    start(0);
    go_to(0, 90000);
    fake_switch(0, SWITCH_HOME, OPEN);
    TEST_ASSERT_TRUE(bench_until(0, AXIS_DONE));
    bench_rounds(5);
    TEST_ASSERT_EQUAL_UINT16(TRIP_OPENED, bench_input(REG_INPUT_trip_code));
    TEST_ASSERT_EQUAL_INT32(-steps_at(90000),
                            (int32_t)bench_input_wide(REG_INPUT_trip_position_steps));
}

static void inverted_switch_closes_high(void)
{
    bench_settings()->inputs_inverted = 1;
    fake_switch(0, SWITCH_HOME, CLOSED);
    bench_rounds(40);
    queue_seek(0, 0, 1, 200);
    start(0);
    go_to(0, 90000);
    fake_switch(0, SWITCH_HOME, OPEN);
    TEST_ASSERT_TRUE(bench_until(0, AXIS_DONE));
    bench_rounds(5);
    TEST_ASSERT_EQUAL_UINT16(TRIP_CLOSED, bench_input(REG_INPUT_trip_code));
}

static void bouncing_switch_counts_from_its_first_edge(void)
{
    queue_seek(0, 0, 1, 200);
    start(0);
    go_to(0, 200000);
    uint32_t first = fake_now_ticks();
    for (uint8_t i = 0; i < 9; i++) {
        fake_switch(0, SWITCH_HOME, i % 2 == 0 ? CLOSED : OPEN);
        fake_pass(700);
        round_poll();
    }
    TEST_ASSERT_TRUE(bench_until(0, AXIS_DONE));
    bench_rounds(5);
    TEST_ASSERT_EQUAL_UINT32(first, bench_input_wide(REG_INPUT_trip_ticks));
    TEST_ASSERT_EQUAL_INT32(steps_at(200000),
                            (int32_t)bench_input_wide(REG_INPUT_trip_position_steps));
}

static void disturbance_does_not_count(void)
{
    queue_seek(0, 0, 1, 200);
    start(0);
    go_to(0, 200000);
    fake_switch(0, SWITCH_HOME, CLOSED);
    fake_pass(300);
    fake_switch(0, SWITCH_HOME, OPEN);
    go_to(0, 400000);
    TEST_ASSERT_EQUAL_UINT16(TRIP_NONE, bench_input(REG_INPUT_trip_code));
    fake_switch(0, SWITCH_HOME, CLOSED);
    TEST_ASSERT_TRUE(bench_until(0, AXIS_DONE));
    bench_rounds(5);
    TEST_ASSERT_EQUAL_INT32(steps_at(400000),
                            (int32_t)bench_input_wide(REG_INPUT_trip_position_steps));
}

// It was open for longer than the filter asks for in between: the edge is the later one.
static void disturbance_just_before_does_not_count(void)
{
    queue_seek(0, 0, 1, 200);
    start(0);
    go_to(0, 200000);
    fake_switch(0, SWITCH_HOME, CLOSED);
    fake_switch(0, SWITCH_HOME, OPEN);
    go_to(0, 200000 + FILTER_TICKS * 3u / 2u);
    uint32_t edge = fake_now_ticks();
    fake_switch(0, SWITCH_HOME, CLOSED);
    TEST_ASSERT_TRUE(bench_until(0, AXIS_DONE));
    TEST_ASSERT_EQUAL_UINT32(edge, bench_input_wide(REG_INPUT_trip_ticks));
}

// It never was open for so long: the edge is the first one.
static void long_bouncing_counts_from_its_first_edge(void)
{
    queue_seek(0, 0, 1, 200);
    start(0);
    go_to(0, 200000);
    uint32_t first = fake_now_ticks();
    for (uint8_t i = 0; i < 5; i++) {
        fake_switch(0, SWITCH_HOME, CLOSED);
        bench_rounds(7);
        fake_switch(0, SWITCH_HOME, OPEN);
        bench_rounds(2);
    }
    fake_switch(0, SWITCH_HOME, CLOSED);
    TEST_ASSERT_TRUE(bench_until(0, AXIS_DONE));
    TEST_ASSERT_EQUAL_UINT16(TRIP_CLOSED, bench_input(REG_INPUT_trip_code));
    TEST_ASSERT_EQUAL_UINT32(first, bench_input_wide(REG_INPUT_trip_ticks));
}

static void seek_without_its_end_is_not_armed(void)
{
    entry(0, RUN_MARK_START | RUN_START_SEEK, 0);
    entry(0, 0, 0);
    for (uint8_t i = 0; i < CONFIG_QUEUE_ENTRIES - 4u; i++) {
        entry(0, (int16_t)(1 + i % 2), 1);
    }
    TEST_ASSERT_EQUAL(AXIS_LOADED, axes_get(0)->life.state);
    TEST_ASSERT_EQUAL(MODBUS_DEVICE_FAILURE, bench_command(1, COMMAND_ARM));
    TEST_ASSERT_EQUAL_UINT8(NO_AXIS, seek_now()->axis);
    entry(0, RUN_MARK_DOWN, 0);
    entry(0, RUN_MARK_END, 0);
    start(0);
}

// The first interval is part of the delay before the line, however long the board is busy.
static void first_step_comes_in_time_at_any_rate(void)
{
    entry(0, RUN_MARK_START, 0);
    entry(0, 0, 0);
    entry(0, BENCH_PIXEL_TICKS / CONFIG_MIN_INTERVAL_TICKS, 20);
    entry(0, RUN_MARK_END, 0);
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(1, COMMAND_ARM));
    TEST_ASSERT_TRUE(bench_until(0, AXIS_RUNNING));
    TEST_ASSERT_TRUE(axes_get(0)->feed.lead_in_ticks != 0);
}

static void seek_of_an_axis_long_unaccounted_for_starts(void)
{
    queue_seek(BENCH_THIRD, 0, 1, 200);
    fake_pass(1000000); // a round that long stands for many that looked after others
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(BENCH_MASK_OF(BENCH_THIRD), COMMAND_ARM));
    TEST_ASSERT_TRUE(bench_until(BENCH_THIRD, AXIS_RUNNING));
    TEST_ASSERT_EQUAL(FAULT_none, faults_record()->code);
}

static void never_closing_is_a_fault(void)
{
    queue_seek(1, 0, 1, 20);
    start(1);
    TEST_ASSERT_TRUE(bench_until(1, AXIS_DONE));
    bench_rounds(5);
    TEST_ASSERT_EQUAL(FAULT_home_not_found, faults_record()->code);
    TEST_ASSERT_EQUAL_UINT8(1, faults_record()->axis);
    TEST_ASSERT_EQUAL_INT32(2 * RAMP_STEPS + 20 * TOP_STEPS, fake_axes[1].steps);
    TEST_ASSERT_EQUAL_INT32(fake_axes[1].steps, ledger_position(&axes_get(1)->ledger));
}

static void never_opening_is_another(void)
{
    fake_switch(1, SWITCH_HOME, CLOSED);
    bench_rounds(40);
    queue_seek(1, RUN_START_OPEN, 1, 20);
    start(1);
    TEST_ASSERT_TRUE(bench_until(1, AXIS_DONE));
    bench_rounds(5);
    TEST_ASSERT_EQUAL(FAULT_home_stuck, faults_record()->code);
}

static void stopped_seek_is_no_fault(void)
{
    queue_seek(1, 0, 1, 200);
    start(1);
    go_to(1, 100000);
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(2, COMMAND_STOP));
    bench_rounds(50);
    TEST_ASSERT_EQUAL(FAULT_none, faults_record()->code);
    TEST_ASSERT_EQUAL_UINT8(NO_AXIS, seek_now()->axis);
}

static void zero_is_the_edge(void)
{
    stops_at(BENCH_LAST, 1, 300000);
    TEST_ASSERT_EQUAL(MODBUS_DEVICE_FAILURE, bench_command(1, COMMAND_ZERO));
    for (uint8_t i = 0; i < 2; i++) { // once more changes nothing
        TEST_ASSERT_EQUAL(MODBUS_OK,
                          bench_command(BENCH_MASK_OF(BENCH_LAST), COMMAND_ZERO));
        TEST_ASSERT_EQUAL_INT32(fake_axes[BENCH_LAST].steps - steps_at(300000),
                                ledger_position(&axes_get(BENCH_LAST)->ledger));
    }
}

static void one_axis_seeks_at_a_time(void)
{
    queue_seek(0, 0, 1, 200);
    queue_seek(1, 0, 1, 200);
    TEST_ASSERT_EQUAL(MODBUS_DEVICE_FAILURE, bench_command(3, COMMAND_ARM));
    start(0);
    TEST_ASSERT_EQUAL(MODBUS_DEVICE_FAILURE, bench_command(2, COMMAND_ARM));
    fake_switch(0, SWITCH_HOME, CLOSED);
    TEST_ASSERT_TRUE(bench_until(0, AXIS_DONE));
    bench_rounds(5);
    start(1);
}

static void seek_does_not_follow_another_line_unasked(void)
{
    entry(0, RUN_MARK_START, 0);
    entry(0, 0, 0);
    entry(0, 5, 2);
    entry(0, RUN_MARK_END, 0);
    queue_seek(0, 0, 1, 200);
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(1, COMMAND_ARM));
    TEST_ASSERT_TRUE(bench_until(0, AXIS_RUNNING));
    TEST_ASSERT_TRUE(bench_until(0, AXIS_LOADED));
    bench_rounds(100);
    TEST_ASSERT_EQUAL_INT32(10, fake_axes[0].steps);
}

// A clock edge is captured with the clock's axis as it is then, the switch's with the axis that
// seeks. Where that is one and the same, the account must not pass the older of both.
static void check_trip(uint32_t ticks, int32_t steps)
{
    TEST_ASSERT_EQUAL(FAULT_none, faults_record()->code);
    TEST_ASSERT_EQUAL_UINT16(TRIP_CLOSED, bench_input(REG_INPUT_trip_code));
    TEST_ASSERT_EQUAL_UINT32(ticks, bench_input_wide(REG_INPUT_trip_ticks));
    TEST_ASSERT_EQUAL_INT32(steps,
                            (int32_t)bench_input_wide(REG_INPUT_trip_position_steps));
}

// The clock has been seen, but not where.
static void check_clock_edge_let_pass(void)
{
    TEST_ASSERT_FALSE(pixel_clock_waiting());
    TEST_ASSERT_FALSE(reference_overdue());
    TEST_ASSERT_FALSE(reference_watch()->known);
}

static void start_on_the_clocks_axis(void)
{
    setUp();
    queue_seek(CONFIG_PIXEL_CLOCK_AXIS, 0, 1, 200);
    start(CONFIG_PIXEL_CLOCK_AXIS);
    go_to(CONFIG_PIXEL_CLOCK_AXIS, 408000); // half a pixel before an edge
    round_poll();
}

// The switch closes at this tick; then so much time passes without a round.
static void close_at(uint8_t axis, uint32_t ticks, uint32_t then_ticks)
{
    fake_pass(ticks - fake_now_ticks());
    fake_switch(axis, SWITCH_HOME, CLOSED);
    fake_pass(then_ticks);
    TEST_ASSERT_TRUE(pixel_clock_waiting());
    // What a command asks for now must wait.
    TEST_ASSERT_FALSE(axes_follow(axis));
    TEST_ASSERT_FALSE(axes_follow(CONFIG_SWITCH_CAPTURE_AXIS));
}

static void seek_on_the_clocks_axis(uint32_t trip, uint32_t then_ticks)
{
    uint32_t zero = axes_get(CONFIG_PIXEL_CLOCK_AXIS)->zero_ticks;

    close_at(CONFIG_PIXEL_CLOCK_AXIS, trip, then_ticks);
    round_poll();
    check_clock_edge_let_pass();
    TEST_ASSERT_TRUE(axes_follow(CONFIG_PIXEL_CLOCK_AXIS));
    TEST_ASSERT_TRUE(bench_until(CONFIG_PIXEL_CLOCK_AXIS, AXIS_DONE));
    check_trip(trip, steps_at(trip - zero));
}

static void clock_edge_and_switch_edge_wait_together(void)
{
    static const uint16_t apart[] = {0, 1, 300, 1999, 5000};

    for (uint8_t i = 0; i < (uint8_t)(sizeof apart / sizeof apart[0]); i++) {
        start_on_the_clocks_axis();
        seek_on_the_clocks_axis(fake_next_edge_ticks() + apart[i], 100);
        start_on_the_clocks_axis();
        seek_on_the_clocks_axis(fake_next_edge_ticks() - apart[i], apart[i] + 100u);
    }
}

// It comes between the two looks of a round: the switch's edge is taken first, then it is too old.
static void clock_edge_between_two_looks_is_let_pass(void)
{
    start_on_the_clocks_axis();
    uint32_t trip = fake_next_edge_ticks() + 500u;
    uint32_t zero = axes_get(CONFIG_PIXEL_CLOCK_AXIS)->zero_ticks;
    fake_pass(trip - fake_now_ticks());
    fake_switch(CONFIG_PIXEL_CLOCK_AXIS, SWITCH_HOME, CLOSED);
    fake_pass(1000);
    seek_poll();
    check_clock_edge_let_pass();
    TEST_ASSERT_TRUE(bench_until(CONFIG_PIXEL_CLOCK_AXIS, AXIS_DONE));
    check_trip(trip, steps_at(trip - zero));
}

// Only the axis of its timer has a sample in a clock edge.
static void clock_edge_that_waits_holds_up_its_own_axis_only(void)
{
    fake_pass(fake_next_edge_ticks() + 100u - fake_now_ticks());
    TEST_ASSERT_TRUE(pixel_clock_waiting());
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        TEST_ASSERT_EQUAL(i != CONFIG_PIXEL_CLOCK_AXIS, axes_follow(i));
    }
    round_poll();
    TEST_ASSERT_TRUE(axes_follow(CONFIG_PIXEL_CLOCK_AXIS));
}

// Another axis seeks: both edges count.
static void clock_edge_beside_a_seek_of_another_axis_counts(void)
{
    queue_seek(BENCH_SECOND, 0, 1, 200);
    start(BENCH_SECOND);
    go_to(BENCH_SECOND, 408000);
    round_poll();
    uint32_t edge = fake_next_edge_ticks();
    close_at(BENCH_SECOND, edge, 3000);
    round_poll();
    TEST_ASSERT_FALSE(reference_overdue());
    TEST_ASSERT_TRUE(reference_watch()->known);
    TEST_ASSERT_TRUE(bench_until(BENCH_SECOND, AXIS_DONE));
    check_trip(edge, steps_at(edge - axes_get(BENCH_SECOND)->zero_ticks));
}

// A long interval is made of several periods, of which one carries the step.
static void edge_inside_a_long_interval(void)
{
    bench_settings()->pixel_hz_num[1] = BENCH_PIXEL_HZ / 100u;
    limits_apply_settings();
    bench_clock_off();
    queue_seek(0, 0, 1, 40);
    start(0);
    bench_rounds(3200); // three pixels
    for (uint8_t i = 0; i < 3; i++) {
        int32_t steps = fake_axes[0].steps;
        while (fake_axes[0].steps == steps) {
            bench_rounds(1);
        }
        // A fifth of the interval is over: the next period but one has no step either.
        bench_rounds(30);
    }
    int32_t before = fake_axes[0].steps;
    fake_switch(0, SWITCH_HOME, CLOSED);
    bench_rounds(10);
    TEST_ASSERT_EQUAL_INT32(before, fake_axes[0].steps);
    TEST_ASSERT_TRUE(bench_until(0, AXIS_DONE));
    TEST_ASSERT_EQUAL_UINT16(TRIP_CLOSED, bench_input(REG_INPUT_trip_code));
    TEST_ASSERT_EQUAL_INT32(before,
                            (int32_t)bench_input_wide(REG_INPUT_trip_position_steps));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(edge_has_its_tick_and_position);
    RUN_TEST(stop_is_controlled_and_soon);
    RUN_TEST(trip_while_speeding_up);
    RUN_TEST(switch_already_closed_makes_no_step);
    RUN_TEST(opening_is_sought_too);
    RUN_TEST(inverted_switch_closes_high);
    RUN_TEST(bouncing_switch_counts_from_its_first_edge);
    RUN_TEST(disturbance_does_not_count);
    RUN_TEST(disturbance_just_before_does_not_count);
    RUN_TEST(long_bouncing_counts_from_its_first_edge);
    RUN_TEST(seek_without_its_end_is_not_armed);
    RUN_TEST(first_step_comes_in_time_at_any_rate);
    RUN_TEST(seek_of_an_axis_long_unaccounted_for_starts);
    RUN_TEST(never_closing_is_a_fault);
    RUN_TEST(never_opening_is_another);
    RUN_TEST(stopped_seek_is_no_fault);
    RUN_TEST(zero_is_the_edge);
    RUN_TEST(one_axis_seeks_at_a_time);
    RUN_TEST(clock_edge_and_switch_edge_wait_together);
    RUN_TEST(clock_edge_between_two_looks_is_let_pass);
    RUN_TEST(clock_edge_that_waits_holds_up_its_own_axis_only);
    RUN_TEST(clock_edge_beside_a_seek_of_another_axis_counts);
    RUN_TEST(seek_does_not_follow_another_line_unasked);
    RUN_TEST(edge_inside_a_long_interval);
    return UNITY_END();
}
