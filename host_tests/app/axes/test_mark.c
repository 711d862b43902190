// SPDX-License-Identifier: MIT
// The mark: when it was set, how often, and whether the clock came as it should since.
#include <stdbool.h>
#include <stdint.h>

#include "app/axes/mark.h"
#include "fakes/board.h"
#include "fakes/board_bench.h"
#include "hal/clock.h"
#include "hal/uart.h"
#include "unity.h"
#include "wire/register_map.h"

void setUp(void)
{
    bench_power_on();
    bench_settings()->bus_timeout_ms = 0;
    limits_apply_settings();
}

void tearDown(void)
{
}

#if FEATURE_TOKENS

static void give_mark(void)
{
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(0, COMMAND_MARK));
}

static void marks_are_counted_up_to_255_and_from_0(void)
{
    uint8_t before = mark_now()->count;

    for (uint16_t marks = 1; marks <= 300; marks++) {
        give_mark();
        TEST_ASSERT_EQUAL_UINT8(before + marks, mark_now()->count);
        TEST_ASSERT_EQUAL_UINT16((uint8_t)(before + marks),
                                 bench_input(REG_INPUT_mark_count));
    }
}

static void a_mark_has_its_time(void)
{
    for (uint8_t i = 0; i < 20; i++) {
        fake_pass(12345u);
        give_mark();
        TEST_ASSERT_EQUAL_UINT32(mark_now()->units,
                                 bench_input_wide(REG_INPUT_mark_units));
        TEST_ASSERT_EQUAL_UINT32(clock_now_units() - uart_age_units(), mark_now()->units);
    }
}

static void a_mark_is_steady_until_the_clock_is_disturbed(void)
{
    TEST_ASSERT_FALSE(mark_now()->steady);
    bench_rounds(300);
    give_mark();
    TEST_ASSERT_EQUAL_UINT16(1, bench_input(REG_INPUT_mark_steady));
    bench_rounds(300);
    TEST_ASSERT_EQUAL_UINT16(1, bench_input(REG_INPUT_mark_steady));
    mark_disturb();
    TEST_ASSERT_EQUAL_UINT16(0, bench_input(REG_INPUT_mark_steady));
    give_mark();
    TEST_ASSERT_EQUAL_UINT16(1, bench_input(REG_INPUT_mark_steady));
    bench_clock_off();
    bench_rounds(300);
    TEST_ASSERT_EQUAL_UINT16(0, bench_input(REG_INPUT_mark_steady));
}

static void line_zeros_number_is_kept(void)
{
    give_mark();
    uint8_t count = mark_now()->count;
    mark_zero(54321u);
    TEST_ASSERT_EQUAL_UINT16(54321u, mark_now()->zero_edge);
    TEST_ASSERT_EQUAL_UINT8(count, mark_now()->count);
    give_mark();
    TEST_ASSERT_EQUAL_UINT16(54321u, mark_now()->zero_edge);
}

#endif

int main(void)
{
    UNITY_BEGIN();
#if FEATURE_TOKENS
    RUN_TEST(marks_are_counted_up_to_255_and_from_0);
    RUN_TEST(a_mark_has_its_time);
    RUN_TEST(a_mark_is_steady_until_the_clock_is_disturbed);
    RUN_TEST(line_zeros_number_is_kept);
#endif
    return UNITY_END();
}
