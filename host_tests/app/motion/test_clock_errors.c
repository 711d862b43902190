// SPDX-License-Identifier: MIT
// Errors of the pixel clock's edges, in the records of the axes whose lines began with the clock.
#include <stdint.h>

#include "fakes/board.h"
#include "fakes/board_bench.h"
#include "unity.h"
#include "wire/register_map.h"

#if SEVERAL_AXES && FEATURE_CLOCK_STATISTICS

#define LATER_TICKS 4 // an edge than the edge before it and a pixel
#define PIXELS      40u

void setUp(void)
{
    bench_power_on();
    bench_rounds(20);
}

void tearDown(void)
{
}

// Each pixel of the clock is LATER_TICKS longer than the setting has it.
static void slow_clock(void)
{
    fake_pixel_clock(
        fake_next_edge_ticks(), CONFIG_TIMER_HZ, BENCH_PIXEL_TICKS + LATER_TICKS);
}

static int16_t error_of(uint8_t axis, uint8_t number)
{
    uint16_t at = (uint16_t)(REG_RECORD_BASE + axis * REG_RECORD_STRIDE +
                             REG_RECORD_HEADER + number * REG_RECORD_WORDS);

    return (int16_t)bench_input((uint16_t)(at + 5u));
}

static uint8_t records_of(uint8_t axis)
{
    return (uint8_t)bench_input(
        (uint16_t)(REG_RECORD_BASE + axis * REG_RECORD_STRIDE + 2u));
}

static void check_errors_grow(uint8_t axis)
{
    TEST_ASSERT_GREATER_THAN_UINT8(5, records_of(axis));
    for (uint8_t i = 1; i < records_of(axis); i++) {
        TEST_ASSERT_INT16_WITHIN(
            1, LATER_TICKS, error_of(axis, i) - error_of(axis, (uint8_t)(i - 1u)));
    }
    TEST_ASSERT_GREATER_THAN_INT16(LATER_TICKS * 20, error_of(axis, 5));
}

static void start_without_clock(uint8_t axis)
{
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_entry(axis, LINE_MARK_START, 0));
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_entry(axis, 0, 0));
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_entry(axis, 5, 2u * PIXELS));
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_entry(axis, LINE_MARK_END, 0));
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(BENCH_MASK_OF(axis), COMMAND_ARM));
}

// Every axis that began with the clock has the errors of its edges; one that did not has none.
static void errors_belong_to_lines_that_began_with_the_clock(uint8_t clocked,
                                                             uint8_t other)
{
    bench_plain_line(clocked, 6, PIXELS);
    start_without_clock(other);
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(BENCH_MASK_OF(clocked), COMMAND_ARM));
    slow_clock();
    TEST_ASSERT_TRUE(bench_until(clocked, AXIS_DONE));
    TEST_ASSERT_EQUAL(AXIS_RUNNING, axes_get(other)->life.state);
    check_errors_grow(clocked);
    TEST_ASSERT_GREATER_THAN_UINT8(5, records_of(other));
    for (uint8_t i = 0; i < records_of(other); i++) {
        TEST_ASSERT_EQUAL_INT16(0, error_of(other, i));
    }
    TEST_ASSERT_EQUAL(FAULT_none, faults_record()->code);
}

static void errors_where_the_clocks_axis_began_with_it(void)
{
    errors_belong_to_lines_that_began_with_the_clock(CONFIG_PIXEL_CLOCK_AXIS, 0);
}

static void errors_where_another_axis_began_with_it(void)
{
    errors_belong_to_lines_that_began_with_the_clock(0, CONFIG_PIXEL_CLOCK_AXIS);
}

static void errors_of_all_axes(void)
{
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        bench_plain_line(i, (int16_t)(5 + i), PIXELS);
    }
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(BENCH_ALL_AXES, COMMAND_ARM));
    slow_clock();
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        TEST_ASSERT_TRUE(bench_until(i, AXIS_DONE));
    }
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        check_errors_grow(i);
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(errors_where_the_clocks_axis_began_with_it);
    RUN_TEST(errors_where_another_axis_began_with_it);
    RUN_TEST(errors_of_all_axes);
    return UNITY_END();
}

#else

void setUp(void)
{
}

void tearDown(void)
{
}

static void several_axes_only(void)
{
    TEST_IGNORE();
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(several_axes_only);
    return UNITY_END();
}

#endif
