// SPDX-License-Identifier: MIT
// The shortest intervals of a line: an axis that does not move has those of an axis alone, others
// those of all that move, whichever axes these are.
#include <stdbool.h>
#include <stdint.h>

#include "fakes/board.h"
#include "fakes/board_bench.h"
#include "unity.h"

void setUp(void)
{
    bench_power_on();
    bench_settings()->bus_timeout_ms = 0;
    limits_apply_settings();
}

void tearDown(void)
{
}

// What the settings say is in force at once, and again after a reset.
static void the_boards_own_clock(void)
{
    TEST_ASSERT_EQUAL_UINT16(0, fake_clock_out_hz);
    bench_settings()->clock_out_hz = 30;
    limits_apply_settings();
    TEST_ASSERT_EQUAL_UINT16(30, fake_clock_out_hz);
    bench_settings()->clock_out_hz = 0;
    limits_apply_settings();
    TEST_ASSERT_EQUAL_UINT16(0, fake_clock_out_hz);
}

#if CONFIG_AXES > 1

// Of so many axes that move; the table of the board file goes up to all of them.
static const uint16_t plain_ticks[] = {0,
                                       BOARD_MIN_INTERVAL_1_TICKS,
                                       BOARD_MIN_INTERVAL_2_TICKS,
                                       BOARD_MIN_INTERVAL_3_TICKS};
static const uint16_t smooth_ticks[] = {0,
                                        BOARD_SMOOTH_MIN_INTERVAL_1_TICKS,
                                        BOARD_SMOOTH_MIN_INTERVAL_2_TICKS,
                                        BOARD_SMOOTH_MIN_INTERVAL_3_TICKS};

static void check_limits(const struct line_limits *limits, uint8_t axes)
{
    bool all = axes == CONFIG_AXES;

    TEST_ASSERT_EQUAL_UINT16(all ? BOARD_MIN_INTERVAL_TICKS : plain_ticks[axes],
                             limits->min_interval_ticks);
    TEST_ASSERT_EQUAL_UINT16(all ? BOARD_SMOOTH_MIN_INTERVAL_TICKS : smooth_ticks[axes],
                             limits->smooth_min_interval_ticks);
}

static void each_number_of_axes(void)
{
    for (uint8_t axes = 1; axes <= CONFIG_AXES; axes++) {
        check_limits(limits_together(axes), axes);
    }
    check_limits(limits_together(0), 1);
}

static uint8_t number_in(uint8_t mask)
{
    uint8_t number = 0;

    for (; mask != 0; mask = (uint8_t)(mask & (mask - 1u))) {
        number++;
    }
    return number;
}

static void load_set(uint8_t mask)
{
    for (uint8_t axis = 0; axis < CONFIG_AXES; axis++) {
        if ((mask & BENCH_MASK_OF(axis)) != 0) {
            bench_plain_line(axis, 10, 2000);
        }
    }
    TEST_ASSERT_EQUAL(MODBUS_OK, mask ? bench_command(mask, COMMAND_ARM) : MODBUS_OK);
}

static void check_set(uint8_t mask)
{
    for (uint8_t axis = 0; axis < CONFIG_AXES; axis++) {
        bool moves = (mask & BENCH_MASK_OF(axis)) != 0;
        check_limits(limits_of(axis), moves ? number_in(mask) : 1u);
    }
}

static void until_set_runs(uint8_t mask)
{
    for (uint8_t axis = 0; axis < CONFIG_AXES; axis++) {
        bool moves = (mask & BENCH_MASK_OF(axis)) != 0;
        TEST_ASSERT_TRUE(!moves || bench_until(axis, AXIS_RUNNING));
    }
}

static void every_set_of_axes_that_move(void)
{
    for (uint16_t set = 0; set <= BENCH_ALL_AXES; set++) {
        uint8_t mask = (uint8_t)set;
        setUp();
        load_set(mask);
        check_set(mask);
        until_set_runs(mask);
        check_set(mask);
    }
}

#endif

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(the_boards_own_clock);
#if CONFIG_AXES > 1
    RUN_TEST(each_number_of_axes);
    RUN_TEST(every_set_of_axes_that_move);
#endif
    return UNITY_END();
}
