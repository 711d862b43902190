// SPDX-License-Identifier: MIT
// A home switch that is a limit switch too (setting home_is_limit), on the fake board: wired to the
// home pin alone, or to the limit's pin as well.
#include <stdint.h>

#include "app/round.h"
#include "fakes/board.h"
#include "hal/switches.h"
#include "nothing_moves.h"
#include "seek_bench.h"
#include "unity.h"
#include "wire/register_map.h"

// Rounds that are longer than the filter's time, by a little.
#define FILTER_ROUNDS   ((uint16_t)(FILTER_TICKS / BENCH_ROUND_TICKS + 10u))
#define AXIS_MASK(axis) ((uint16_t)(1u << (axis)))
#define MINUS_OF(axis)  ((uint16_t)(1u << (2u * (axis))))
#define PLUS_OF(axis)   ((uint16_t)(2u << (2u * (axis))))
// A shared switch stops a line of TOP_STEPS a pixel within its filter's time and a pixel.
#define STOP_STEPS    ((int32_t)(8u * FILTER_TICKS / BENCH_PIXEL_TICKS + 8u))
#define AT_ONCE_STEPS 4

static void share(uint16_t bits)
{
    bench_settings()->home_is_limit = bits;
}

static void close_home(uint8_t axis)
{
    fake_switch(axis, SWITCH_HOME, CLOSED);
}

static void close_both(uint8_t axis, uint8_t limit)
{
    fake_switch(axis, SWITCH_HOME, CLOSED);
    fake_switch(axis, limit, CLOSED);
}

static void start_line(uint8_t axis, int16_t count)
{
    bench_plain_line(axis, count, 100);
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(AXIS_MASK(axis), COMMAND_ARM));
    TEST_ASSERT_TRUE(bench_until(axis, AXIS_RUNNING));
}

static void forget_fault(uint8_t axis)
{
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(AXIS_MASK(axis), COMMAND_CLEAR_FAULT));
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(AXIS_MASK(axis), COMMAND_DISCARD));
}

static void check_fault(enum fault fault, uint8_t axis)
{
    TEST_ASSERT_EQUAL(fault, faults_record()->code);
    TEST_ASSERT_EQUAL_UINT8(axis, faults_record()->axis);
    TEST_ASSERT_EQUAL(AXIS_FAULT, axes_get(axis)->life.state);
    check_nothing_moves();
}

static void check_found(uint8_t axis)
{
    TEST_ASSERT_TRUE(bench_until(axis, AXIS_DONE));
    bench_rounds(FILTER_ROUNDS);
    TEST_ASSERT_EQUAL(FAULT_none, faults_record()->code);
    TEST_ASSERT_EQUAL_UINT16(TRIP_CLOSED, bench_input(REG_INPUT_trip_code));
}

// The axis stands on its switch: on towards it is a fault at once, away from it is none.
static void check_away_only(uint8_t axis, int16_t towards, enum fault fault)
{
    int32_t before = fake_axes[axis].steps;

    start_line(axis, towards);
    TEST_ASSERT_TRUE(bench_until(axis, AXIS_FAULT));
    check_fault(fault, axis);
    int32_t made = fake_axes[axis].steps - before;
    TEST_ASSERT_TRUE(made * towards > 0 &&
                     made * (towards < 0 ? -1 : 1) <= AT_ONCE_STEPS);
    forget_fault(axis);
    start_line(axis, (int16_t)-towards);
    TEST_ASSERT_TRUE(bench_until(axis, AXIS_DONE));
    TEST_ASSERT_EQUAL(FAULT_none, faults_record()->code);
}

static void seek_to(uint8_t axis, int16_t sign, bool both)
{
    setUp();
    share((uint16_t)(sign > 0 ? PLUS_OF(axis) : MINUS_OF(axis)));
    queue_seek(axis, 0, sign, 200);
    start_seek(axis);
    go_to(axis, 200000);
    if (both) {
        close_both(axis, sign > 0 ? SWITCH_LIMIT_PLUS : SWITCH_LIMIT_MINUS);
    } else {
        close_home(axis);
    }
    check_found(axis);
    TEST_ASSERT_EQUAL_INT32(sign * steps_at(200000),
                            (int32_t)bench_input_wide(REG_INPUT_trip_position_steps));
    check_away_only(
        axis, (int16_t)(8 * sign), sign > 0 ? FAULT_limit_plus : FAULT_limit_minus);
}

static void seek_ends_on_its_limit(void)
{
    for (uint8_t both = 0; both < 2; both++) {
        seek_to(0, 1, both != 0);
        seek_to(0, -1, both != 0);
        seek_to(BENCH_THIRD, -1, both != 0);
        seek_to(BENCH_LAST, 1, both != 0);
    }
}

// The new position is no move.
static void zero_on_the_switch_leads_away_only(void)
{
    share(PLUS_OF(0));
    queue_seek(0, 0, 1, 200);
    start_seek(0);
    go_to(0, 200000);
    close_home(0);
    check_found(0);
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(1, COMMAND_ZERO));
    start_line(0, -8);
    TEST_ASSERT_TRUE(bench_until(0, AXIS_DONE));
    TEST_ASSERT_EQUAL(FAULT_none, faults_record()->code);
    start_line(0, 8);
    TEST_ASSERT_TRUE(bench_until(0, AXIS_FAULT));
    TEST_ASSERT_EQUAL(FAULT_limit_plus, faults_record()->code);
}

static void line_to(uint8_t axis, int16_t count, uint16_t bits, enum fault fault)
{
    setUp();
    share(bits);
    start_line(axis, count);
    bench_rounds(300);
    int32_t before = fake_axes[axis].steps;
    close_home(axis);
    bench_rounds(FILTER_ROUNDS + 10u);
    check_fault(fault, axis);
    int32_t after = fake_axes[axis].steps - before;
    TEST_ASSERT_TRUE(after * count > 0 && after * (count < 0 ? -1 : 1) <= STOP_STEPS);
    forget_fault(axis);
    check_away_only(axis, count, fault);
}

static void lines_stop_at_it(void)
{
    line_to(0, 8, PLUS_OF(0), FAULT_limit_plus);
    line_to(0, -8, MINUS_OF(0), FAULT_limit_minus);
    line_to(BENCH_LAST, 8, PLUS_OF(BENCH_LAST), FAULT_limit_plus);
    line_to(BENCH_THIRD, -8, MINUS_OF(BENCH_THIRD), FAULT_limit_minus);
}

static void line_passes(uint8_t axis, int16_t count, uint16_t bits)
{
    setUp();
    share(bits);
    start_line(axis, count);
    bench_rounds(300);
    close_home(axis);
    TEST_ASSERT_TRUE(bench_until(axis, AXIS_DONE));
    TEST_ASSERT_EQUAL(FAULT_none, faults_record()->code);
}

static void a_home_switch_alone_stops_nothing(void)
{
    line_passes(0, 8, 0);
    line_passes(0, -8, PLUS_OF(0));
    line_passes(0, 8, MINUS_OF(0));
#if CONFIG_AXES > 1
    line_passes(1, 8, PLUS_OF(0));
    line_passes(0, 8, PLUS_OF(1));
#endif
}

static void seek_from_a_closed_switch_goes_nowhere(void)
{
    share(PLUS_OF(0));
    close_both(0, SWITCH_LIMIT_PLUS);
    bench_rounds(FILTER_ROUNDS);
    TEST_ASSERT_EQUAL(FAULT_none, faults_record()->code);
    queue_seek(0, 0, 1, 200);
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(1, COMMAND_ARM));
    TEST_ASSERT_TRUE(bench_until(0, AXIS_DONE));
    bench_rounds(FILTER_ROUNDS);
    TEST_ASSERT_EQUAL_UINT16(TRIP_ALREADY, bench_input(REG_INPUT_trip_code));
    TEST_ASSERT_EQUAL_INT32(0, fake_axes[0].steps);
    TEST_ASSERT_EQUAL(FAULT_none, faults_record()->code);
}

static void seek_for_opening_leads_away_only(void)
{
    share(PLUS_OF(0));
    close_both(0, SWITCH_LIMIT_PLUS);
    bench_rounds(FILTER_ROUNDS);
    queue_seek(0, LINE_START_OPEN, 1, 200);
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(1, COMMAND_ARM));
    TEST_ASSERT_TRUE(bench_until(0, AXIS_FAULT));
    check_fault(FAULT_limit_plus, 0);
    TEST_ASSERT_TRUE(fake_axes[0].steps <= AT_ONCE_STEPS);
    forget_fault(0);
    queue_seek(0, LINE_START_OPEN, -1, 200);
    start_seek(0);
    bench_rounds(600);
    fake_switch(0, SWITCH_HOME, OPEN);
    fake_switch(0, SWITCH_LIMIT_PLUS, OPEN);
    TEST_ASSERT_TRUE(bench_until(0, AXIS_DONE));
    TEST_ASSERT_EQUAL_UINT16(TRIP_OPENED, bench_input(REG_INPUT_trip_code));
    TEST_ASSERT_EQUAL(FAULT_none, faults_record()->code);
}

// The limit's own pin still stops a seek when the wire to the home pin is broken.
static void limit_whose_home_pin_is_dead_stops_a_seek(void)
{
    share(PLUS_OF(0));
    queue_seek(0, 0, 1, 200);
    start_seek(0);
    go_to(0, 200000);
    fake_switch(0, SWITCH_LIMIT_PLUS, CLOSED);
    TEST_ASSERT_TRUE(bench_until(0, AXIS_FAULT));
    check_fault(FAULT_limit_plus, 0);
}

// What the home switch does not share stops a seek that has found it.
static void limit_of_the_other_kind_is_no_part_of_it(void)
{
    share(MINUS_OF(0));
    queue_seek(0, 0, 1, 200);
    start_seek(0);
    go_to(0, 200000);
    close_both(0, SWITCH_LIMIT_PLUS);
    TEST_ASSERT_TRUE(bench_until(0, AXIS_FAULT));
    check_fault(FAULT_limit_plus, 0);
}

// Both pins bounce, the limit's a little sooner or later than the home switch's.
static void bounce(bool limit_first)
{
    for (uint8_t i = 0; i < 9; i++) {
        bool level = i % 2 == 0 ? CLOSED : OPEN;
        fake_switch(0, limit_first ? SWITCH_LIMIT_PLUS : SWITCH_HOME, level);
        fake_pass(700);
        round_poll();
        fake_switch(0, limit_first ? SWITCH_HOME : SWITCH_LIMIT_PLUS, level);
        fake_pass(500);
        round_poll();
    }
}

static void bouncing_ends_a_seek_and_stops_a_line(void)
{
    for (uint8_t limit_first = 0; limit_first < 2; limit_first++) {
        setUp();
        share(PLUS_OF(0));
        queue_seek(0, 0, 1, 200);
        start_seek(0);
        go_to(0, 200000);
        bounce(limit_first != 0);
        check_found(0);
        setUp();
        share(PLUS_OF(0));
        start_line(0, 8);
        bench_rounds(300);
        bounce(limit_first != 0);
        TEST_ASSERT_EQUAL(FAULT_none, faults_record()->code);
        bench_rounds(FILTER_ROUNDS);
        check_fault(FAULT_limit_plus, 0);
    }
}

// The edge was a disturbance: the limit waits no longer.
static void disturbance_does_not_hold_the_limit_back(void)
{
    share(PLUS_OF(0));
    queue_seek(0, 0, 1, 200);
    start_seek(0);
    go_to(0, 200000);
    close_home(0);
    fake_pass(300);
    fake_switch(0, SWITCH_HOME, OPEN);
    bench_rounds(2u * FILTER_ROUNDS);
    fake_switch(0, SWITCH_LIMIT_PLUS, CLOSED);
    bench_rounds(FILTER_ROUNDS + 10u);
    check_fault(FAULT_limit_plus, 0);
}

#if CONFIG_AXES > 1
// One axis seeks, another runs a line: each has its own switch.
static void seek_beside_a_line(uint8_t closes)
{
    share(PLUS_OF(0) | PLUS_OF(1));
    start_line(1, 8);
    queue_seek(0, 0, 1, 200);
    start_seek(0);
    go_to(0, 100000);
    close_home(closes);
}

static void seek_of_one_axis_is_no_excuse_of_another(void)
{
    seek_beside_a_line(1);
    TEST_ASSERT_TRUE(bench_until(1, AXIS_FAULT));
    check_fault(FAULT_limit_plus, 1);
    TEST_ASSERT_EQUAL(AXIS_FAULT, axes_get(0)->life.state);
    setUp();
    seek_beside_a_line(0);
    close_home(1);
    TEST_ASSERT_TRUE(bench_until(1, AXIS_FAULT));
    check_fault(FAULT_limit_plus, 1);
}

static void switch_of_a_seek_leaves_other_axes_alone(void)
{
    seek_beside_a_line(0);
    check_found(0);
    TEST_ASSERT_TRUE(bench_until(1, AXIS_DONE));
    TEST_ASSERT_EQUAL(FAULT_none, faults_record()->code);
}
#endif

// A stopped seek stands on the switch like any other.
static void stop_behind_the_switch(void)
{
    share(PLUS_OF(0));
    queue_seek(0, 0, 1, 200);
    start_seek(0);
    go_to(0, 200000);
    close_home(0);
    bench_rounds(FILTER_ROUNDS);
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(1, COMMAND_STOP));
    bench_rounds(2u * FILTER_ROUNDS);
    TEST_ASSERT_EQUAL(FAULT_none, faults_record()->code);
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(1, COMMAND_DISCARD));
    check_away_only(0, 8, FAULT_limit_plus);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(seek_ends_on_its_limit);
    RUN_TEST(zero_on_the_switch_leads_away_only);
    RUN_TEST(lines_stop_at_it);
    RUN_TEST(a_home_switch_alone_stops_nothing);
    RUN_TEST(seek_from_a_closed_switch_goes_nowhere);
    RUN_TEST(seek_for_opening_leads_away_only);
    RUN_TEST(limit_whose_home_pin_is_dead_stops_a_seek);
    RUN_TEST(limit_of_the_other_kind_is_no_part_of_it);
    RUN_TEST(bouncing_ends_a_seek_and_stops_a_line);
    RUN_TEST(disturbance_does_not_hold_the_limit_back);
#if CONFIG_AXES > 1
    RUN_TEST(seek_of_one_axis_is_no_excuse_of_another);
    RUN_TEST(switch_of_a_seek_leaves_other_axes_alone);
#endif
    RUN_TEST(stop_behind_the_switch);
    return UNITY_END();
}
