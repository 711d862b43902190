// SPDX-License-Identifier: MIT
// Switches of the fake board: the filter, and limit switches that stop an axis that moves on
// towards them.
#include <stdint.h>

#include "fakes/board.h"
#include "fakes/board_bench.h"
#include "hal/switches.h"
#include "nothing_moves.h"
#include "unity.h"
#include "wire/register_map.h"

#define CLOSED false
#define OPEN   true
// Rounds that are longer than the filter's default of 1000 us, by a little.
#define FILTER_ROUNDS ((uint16_t)(BENCH_TICKS_PER_MS / BENCH_ROUND_TICKS + 10u))
// All bits of the register that are a switch or its axis's fourth bit.
#define ALL_SWITCHES ((uint16_t)(0xFFFFu >> (16u - 4u * CONFIG_AXES)))

// Of 8 steps a pixel: those in the filter's time, and a pixel.
#define STOP_STEPS ((int32_t)(8u * BENCH_TICKS_PER_MS / BENCH_PIXEL_TICKS + 8u))

void setUp(void)
{
    bench_power_on();
    bench_rounds(FILTER_ROUNDS);
}

void tearDown(void)
{
}

static void switches_are_four_bits_an_axis(void)
{
    TEST_ASSERT_EQUAL_HEX16(0, bench_input(REG_INPUT_inputs));
    fake_switch(0, SWITCH_HOME, CLOSED);
    fake_switch(1, SWITCH_LIMIT_MINUS, CLOSED);
    fake_switch(BENCH_LAST, SWITCH_LIMIT_PLUS, CLOSED);
    bench_rounds(FILTER_ROUNDS);
    TEST_ASSERT_EQUAL_HEX16(0x0021u | 4u << (4u * BENCH_LAST),
                            bench_input(REG_INPUT_inputs));
}

static void change_counts_when_it_lasts(void)
{
    fake_switch(BENCH_THIRD, SWITCH_HOME, CLOSED);
    bench_rounds(8);
    TEST_ASSERT_EQUAL_HEX16(0, bench_input(REG_INPUT_inputs));
    fake_switch(BENCH_THIRD, SWITCH_HOME, OPEN);
    bench_rounds(4);
    fake_switch(BENCH_THIRD, SWITCH_HOME, CLOSED);
    bench_rounds(8);
    TEST_ASSERT_EQUAL_HEX16(0, bench_input(REG_INPUT_inputs));
    bench_rounds(FILTER_ROUNDS - 8u);
    TEST_ASSERT_EQUAL_HEX16(1u << (4u * BENCH_THIRD), bench_input(REG_INPUT_inputs));
}

// Each switch of each axis is filtered with a time of its own.
static void a_switch_that_changes_leaves_the_others_alone(void)
{
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        for (uint8_t bit = 0; bit < 3; bit++) {
            uint16_t expected = (uint16_t)((1u << bit) << (4u * i));
            fake_switch(i, (uint8_t)(1u << bit), CLOSED);
            bench_rounds(2);
            TEST_ASSERT_EQUAL_HEX16(0, bench_input(REG_INPUT_inputs));
            bench_rounds(FILTER_ROUNDS);
            TEST_ASSERT_EQUAL_HEX16(expected, bench_input(REG_INPUT_inputs));
            fake_switch(i, (uint8_t)(1u << bit), OPEN);
            bench_rounds(2);
            TEST_ASSERT_EQUAL_HEX16(expected, bench_input(REG_INPUT_inputs));
            bench_rounds(FILTER_ROUNDS);
            TEST_ASSERT_EQUAL_HEX16(0, bench_input(REG_INPUT_inputs));
        }
    }
    TEST_ASSERT_EQUAL(FAULT_none, faults_record()->code);
}

static void filter_time_is_a_setting(void)
{
    bench_settings()->input_filter_us = 20000;
    fake_switch(0, SWITCH_HOME, CLOSED);
    bench_rounds((uint16_t)(19uL * BENCH_TICKS_PER_MS / BENCH_ROUND_TICKS));
    TEST_ASSERT_EQUAL_HEX16(0, bench_input(REG_INPUT_inputs));
    bench_rounds((uint16_t)(2uL * BENCH_TICKS_PER_MS / BENCH_ROUND_TICKS + 10u));
    TEST_ASSERT_EQUAL_HEX16(1, bench_input(REG_INPUT_inputs));
}

static void levels_can_be_inverted(void)
{
    bench_settings()->inputs_inverted = 2;
    bench_rounds(FILTER_ROUNDS);
    TEST_ASSERT_EQUAL_HEX16(0x6666u & ALL_SWITCHES, bench_input(REG_INPUT_inputs));
    bench_settings()->inputs_inverted = 1;
    bench_rounds(FILTER_ROUNDS);
    TEST_ASSERT_EQUAL_HEX16(0x1111u & ALL_SWITCHES, bench_input(REG_INPUT_inputs));
}

static void run_line(uint8_t axis, int16_t count)
{
    bench_plain_line(axis, count, 100);
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command((uint16_t)(1u << axis), COMMAND_ARM));
    TEST_ASSERT_TRUE(bench_until(axis, AXIS_RUNNING));
}

// Its filter, a turn of the main loop's and the step that shows it; 8 steps are a pixel.
static void limit_stops(uint8_t axis, int16_t count, uint8_t which, enum fault fault)
{
    setUp();
    run_line(axis, count);
    bench_rounds(300);
    int32_t before = fake_axes[axis].steps;
    fake_switch(axis, which, CLOSED);
    bench_rounds(FILTER_ROUNDS + 10u);
    TEST_ASSERT_EQUAL(fault, faults_record()->code);
    TEST_ASSERT_EQUAL_UINT8(axis, faults_record()->axis);
    TEST_ASSERT_EQUAL(AXIS_FAULT, axes_get(axis)->life.state);
    check_nothing_moves();
    int32_t after = fake_axes[axis].steps - before;
    TEST_ASSERT_TRUE(after * count > 0 && after * (count < 0 ? -1 : 1) <= STOP_STEPS);
    TEST_ASSERT_EQUAL_INT32(fake_axes[axis].steps,
                            ledger_position(&axes_get(axis)->ledger));
}

static void limit_stops_what_moves_towards_it(void)
{
    limit_stops(0, 8, SWITCH_LIMIT_PLUS, FAULT_limit_plus);
    limit_stops(BENCH_LAST, 8, SWITCH_LIMIT_PLUS, FAULT_limit_plus);
    limit_stops(BENCH_THIRD, -8, SWITCH_LIMIT_MINUS, FAULT_limit_minus);
}

static void moving_away_is_allowed(void)
{
    limit_stops(1, 8, SWITCH_LIMIT_PLUS, FAULT_limit_plus);
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(2, COMMAND_CLEAR_FAULT));
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(2, COMMAND_DISCARD));
    run_line(1, -8);
    TEST_ASSERT_TRUE(bench_until(1, AXIS_DONE));
    TEST_ASSERT_EQUAL(FAULT_none, faults_record()->code);
}

static void moving_on_is_not(void)
{
    limit_stops(1, 8, SWITCH_LIMIT_PLUS, FAULT_limit_plus);
    int32_t before = fake_axes[1].steps;
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(2, COMMAND_CLEAR_FAULT));
    run_line(1, 8);
    TEST_ASSERT_TRUE(bench_until(1, AXIS_FAULT));
    TEST_ASSERT_EQUAL(FAULT_limit_plus, faults_record()->code);
    check_nothing_moves();
    TEST_ASSERT_TRUE(fake_axes[1].steps - before <= 4);
}

static void limit_of_an_axis_at_rest_is_no_fault(void)
{
    fake_switch(1, SWITCH_LIMIT_PLUS, CLOSED);
    fake_switch(1, SWITCH_LIMIT_MINUS, CLOSED);
    run_line(0, 8);
    TEST_ASSERT_TRUE(bench_until(0, AXIS_DONE));
    TEST_ASSERT_EQUAL(FAULT_none, faults_record()->code);
}

// 40 rounds, in each of which the axis's turn of every four sees another level.
static void chatter(uint8_t axis, uint8_t which)
{
    for (uint8_t i = 0; i < 40; i++) {
        fake_switch(axis, which, i % 2 == 0 ? CLOSED : OPEN);
        bench_rounds(4);
    }
}

static void chattering_switch_does_not_hide_another(void)
{
    fake_switch(1, SWITCH_LIMIT_PLUS, CLOSED);
    chatter(1, SWITCH_HOME);
    TEST_ASSERT_EQUAL_HEX16(0x0040, bench_input(REG_INPUT_inputs));
    setUp();
    fake_switch(BENCH_THIRD, SWITCH_HOME, CLOSED);
    fake_switch(BENCH_THIRD, SWITCH_LIMIT_MINUS, CLOSED);
    chatter(BENCH_THIRD, SWITCH_LIMIT_PLUS);
    TEST_ASSERT_EQUAL_HEX16(3u << (4u * BENCH_THIRD), bench_input(REG_INPUT_inputs));
}

static void chattering_limit_stays_what_it_was(void)
{
    fake_switch(1, SWITCH_LIMIT_PLUS, CLOSED);
    bench_rounds(FILTER_ROUNDS);
    chatter(1, SWITCH_LIMIT_PLUS);
    TEST_ASSERT_EQUAL_HEX16(0x0040, bench_input(REG_INPUT_inputs));
}

// A position that is changed at rest is no movement.
static void zero_is_no_move_towards_a_limit(void)
{
    run_line(1, 8);
    TEST_ASSERT_TRUE(bench_until(1, AXIS_DONE));
    fake_switch(1, SWITCH_LIMIT_MINUS, CLOSED);
    bench_rounds(FILTER_ROUNDS);
    ledger_zero(&axes_get(1)->ledger, 500);
    bench_rounds(FILTER_ROUNDS);
    run_line(1, 8);
    TEST_ASSERT_TRUE(bench_until(1, AXIS_DONE));
    TEST_ASSERT_EQUAL(FAULT_none, faults_record()->code);
    TEST_ASSERT_EQUAL_INT32(1600, fake_axes[1].steps);
}

static void reversal_towards_a_limit_is_stopped(void)
{
    fake_switch(1, SWITCH_LIMIT_PLUS, CLOSED);
    bench_rounds(FILTER_ROUNDS);
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_entry(1, LINE_MARK_START | LINE_START_WAIT, 0));
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_entry(1, 0, 0));
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_entry(1, -2, 30));
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_entry(1, 2, 30));
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_entry(1, LINE_MARK_END, 0));
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(2, COMMAND_ARM));
    TEST_ASSERT_TRUE(bench_until(1, AXIS_FAULT));
    TEST_ASSERT_EQUAL(FAULT_limit_plus, faults_record()->code);
    check_nothing_moves();
    TEST_ASSERT_TRUE(fake_axes[1].steps <= -60 + 4 && fake_axes[1].steps > -60);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(switches_are_four_bits_an_axis);
    RUN_TEST(change_counts_when_it_lasts);
    RUN_TEST(a_switch_that_changes_leaves_the_others_alone);
    RUN_TEST(filter_time_is_a_setting);
    RUN_TEST(levels_can_be_inverted);
    RUN_TEST(limit_stops_what_moves_towards_it);
    RUN_TEST(moving_away_is_allowed);
    RUN_TEST(moving_on_is_not);
    RUN_TEST(limit_of_an_axis_at_rest_is_no_fault);
    RUN_TEST(chattering_switch_does_not_hide_another);
    RUN_TEST(chattering_limit_stays_what_it_was);
    RUN_TEST(zero_is_no_move_towards_a_limit);
    RUN_TEST(reversal_towards_a_limit_is_stopped);
    return UNITY_END();
}
