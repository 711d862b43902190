// SPDX-License-Identifier: MIT
// Seeks on the fake board: where they stop, which edge of the switch counts, how they fail.
#include <stdint.h>

#include "app/round.h"
#include "fakes/board.h"
#include "hal/switches.h"
#include "nothing_moves.h"
#include "seek_bench.h"
#include "unity.h"
#include "wire/register_map.h"

static void stops_at(uint8_t axis, int16_t sign, uint32_t ticks)
{
    setUp();
    queue_seek(axis, 0, sign, 200);
    start_seek(axis);
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
    queue_seek(0, LINE_START_OPEN, -1, 200);
    start_seek(0);
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
    start_seek(0);
    go_to(0, 90000);
    fake_switch(0, SWITCH_HOME, OPEN);
    TEST_ASSERT_TRUE(bench_until(0, AXIS_DONE));
    bench_rounds(5);
    TEST_ASSERT_EQUAL_UINT16(TRIP_CLOSED, bench_input(REG_INPUT_trip_code));
}

static void bouncing_switch_counts_from_its_first_edge(void)
{
    queue_seek(0, 0, 1, 200);
    start_seek(0);
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
    start_seek(0);
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
    start_seek(0);
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
    start_seek(0);
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
    queue_entry(0, LINE_MARK_START | LINE_START_SEEK, 0);
    queue_entry(0, 0, 0);
    for (uint8_t i = 0; i < CONFIG_QUEUE_ENTRIES - 4u; i++) {
        queue_entry(0, (int16_t)(1 + i % 2), 1);
    }
    TEST_ASSERT_EQUAL(AXIS_LOADED, axes_get(0)->life.state);
    TEST_ASSERT_EQUAL(MODBUS_DEVICE_FAILURE, bench_command(1, COMMAND_ARM));
    TEST_ASSERT_EQUAL_UINT8(NO_AXIS, seek_now()->axis);
    queue_entry(0, LINE_MARK_DOWN, 0);
    queue_entry(0, LINE_MARK_END, 0);
    start_seek(0);
}

// The first interval is part of the delay before the line, however long the board is busy.
static void first_step_comes_in_time_at_any_rate(void)
{
    queue_entry(0, LINE_MARK_START, 0);
    queue_entry(0, 0, 0);
    queue_entry(0, BENCH_PIXEL_TICKS / CONFIG_MIN_INTERVAL_TICKS, 20);
    queue_entry(0, LINE_MARK_END, 0);
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
    start_seek(1);
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
    queue_seek(1, LINE_START_OPEN, 1, 20);
    start_seek(1);
    TEST_ASSERT_TRUE(bench_until(1, AXIS_DONE));
    bench_rounds(5);
    TEST_ASSERT_EQUAL(FAULT_home_stuck, faults_record()->code);
}

static void stopped_seek_is_no_fault(void)
{
    queue_seek(1, 0, 1, 200);
    start_seek(1);
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
    start_seek(0);
    TEST_ASSERT_EQUAL(MODBUS_DEVICE_FAILURE, bench_command(2, COMMAND_ARM));
    fake_switch(0, SWITCH_HOME, CLOSED);
    TEST_ASSERT_TRUE(bench_until(0, AXIS_DONE));
    bench_rounds(5);
    start_seek(1);
}

static void seek_does_not_follow_another_line_unasked(void)
{
    queue_entry(0, LINE_MARK_START, 0);
    queue_entry(0, 0, 0);
    queue_entry(0, 5, 2);
    queue_entry(0, LINE_MARK_END, 0);
    queue_seek(0, 0, 1, 200);
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(1, COMMAND_ARM));
    TEST_ASSERT_TRUE(bench_until(0, AXIS_RUNNING));
    TEST_ASSERT_TRUE(bench_until(0, AXIS_LOADED));
    bench_rounds(100);
    TEST_ASSERT_EQUAL_INT32(10, fake_axes[0].steps);
}

// A board that begins anew listens to no switch.
static void nothing_is_captured_after_a_start(void)
{
    queue_seek(0, 0, 1, 200);
    start_seek(0);
    seek_start();
    fake_switch(0, SWITCH_HOME, CLOSED);
    TEST_ASSERT_FALSE(switch_capture_waiting());
    TEST_ASSERT_EQUAL_UINT8(NO_AXIS, seek_now()->axis);
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
    RUN_TEST(nothing_is_captured_after_a_start);
    RUN_TEST(seek_does_not_follow_another_line_unasked);
    return UNITY_END();
}
