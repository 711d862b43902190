// SPDX-License-Identifier: MIT
// Settings of the bus: address, rate, parity and delay take effect when the reply has left.
#include <stdint.h>

#include "bus_bench.h"
#include "hal/clock.h"
#include "wire/baud.h"

static void reply_delay_comes_on_top(void)
{
    bench_settings()->reply_delay_us = 5000;
    ask_axis_count(7);
    TEST_ASSERT_EQUAL_UINT16(0, answer());
    fake_pass((uint32_t)4 * MS_TICKS);
    bus_port_poll();
    TEST_ASSERT_EQUAL_UINT16(0, taken());
    fake_pass(MS_TICKS);
    bus_port_poll();
    TEST_ASSERT_EQUAL_UINT16(7, taken());
}

static void settings_are_busy_while_moving(void)
{
    bench_plain_line(0, 10, 20);
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(1, COMMAND_ARM));
    PUT(7, 6, 0, 6, 0, 50);
    TEST_ASSERT_EQUAL_UINT16(5, answer());
    TEST_ASSERT_EQUAL_HEX8(0x86, reply[1]);
    TEST_ASSERT_EQUAL_HEX8(MODBUS_BUSY, reply[2]);
}

static void new_address_counts_from_the_next_request(void)
{
    PUT(7, 6, 0, 0, 0, 9);
    TEST_ASSERT_EQUAL_UINT16(8, answer());
    TEST_ASSERT_EQUAL_HEX8(7, reply[0]);
    sent();
    ask_axis_count(9);
    TEST_ASSERT_EQUAL_UINT16(7, answer());
    TEST_ASSERT_EQUAL_HEX8(9, reply[0]);
}

static void line_begins_with_the_settings(void)
{
    TEST_ASSERT_EQUAL_UINT16(baud_divisor(1152), fake_line.divisor);
    TEST_ASSERT_EQUAL(UART_EVEN, fake_line.parity);
    TEST_ASSERT_EQUAL_UINT16(baud_silence_counts(baud_divisor(1152)),
                             fake_line.silence_counts);
    TEST_ASSERT_EQUAL_UINT8(1, fake_line.changes);
}

static void new_rate_counts_when_the_reply_has_left(void)
{
    PUT(7, 6, 0, 1, 0, 96);
    TEST_ASSERT_EQUAL_UINT16(8, answer());
    bus_port_poll();
    TEST_ASSERT_EQUAL_UINT16(baud_divisor(1152), fake_line.divisor);
    sent();
    TEST_ASSERT_EQUAL_UINT16(baud_divisor(96), fake_line.divisor);
    TEST_ASSERT_EQUAL_UINT16(baud_silence_counts(baud_divisor(96)),
                             fake_line.silence_counts);
    ask_axis_count(7);
    check_axis_count();
    TEST_ASSERT_EQUAL_UINT8(2, fake_line.changes);
}

static void new_parity_of_all_counts_at_once(void)
{
    PUT(0, 6, 0, 13, 0, 1);
    bus_port_poll();
    TEST_ASSERT_EQUAL(UART_ODD, fake_line.parity);
    ask_axis_count(7);
    check_axis_count();
}

static void last_request_is_ours_or_everybodys(void)
{
    fake_pass((uint32_t)100 * MS_TICKS);
    uint16_t before = traffic_last_request_ms();
    ask_axis_count(8);
    bus_port_poll();
    TEST_ASSERT_EQUAL_UINT16(before, traffic_last_request_ms());
    PUT(0, 3, 0, 0, 0, 1);
    bus_port_poll();
    TEST_ASSERT_EQUAL_UINT16(clock_now_ms(), traffic_last_request_ms());
    fake_pass((uint32_t)100 * MS_TICKS);
    ask_axis_count(7);
    check_axis_count();
    TEST_ASSERT_TRUE(traffic_last_request_ms() >= 195);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(reply_delay_comes_on_top);
    RUN_TEST(settings_are_busy_while_moving);
    RUN_TEST(new_address_counts_from_the_next_request);
    RUN_TEST(line_begins_with_the_settings);
    RUN_TEST(new_rate_counts_when_the_reply_has_left);
    RUN_TEST(new_parity_of_all_counts_at_once);
    RUN_TEST(last_request_is_ours_or_everybodys);
    return UNITY_END();
}
