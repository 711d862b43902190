// SPDX-License-Identifier: MIT
// The bus port of the fake board: requests come in, replies leave after the silence that ends them.
#include <stdint.h>
#include <string.h>

#include "bus_bench.h"
#include "wire/register_map.h"

static void reply_comes_after_silence(void)
{
    ask_axis_count(7);
    bus_port_poll();
    TEST_ASSERT_EQUAL_UINT16(0, taken());
    fake_pass(SILENCE_TICKS - SLACK_TICKS);
    bus_port_poll();
    bus_port_poll();
    TEST_ASSERT_EQUAL_UINT16(0, taken());
    check_axis_count();
}

static void next_request_is_served(void)
{
    for (uint8_t i = 0; i < 3; i++) {
        ask_axis_count(7);
        check_axis_count();
    }
}

static void damaged_request_is_counted(void)
{
    static const uint8_t request[] = {7, 4, 0, 3, 0, 1, 0x11, 0x22};
    uint16_t errors = traffic_counters()->crc_errors;

    fake_receive(request, sizeof request);
    TEST_ASSERT_EQUAL_UINT16(0, answer());
    TEST_ASSERT_EQUAL_UINT16(errors + 1u, traffic_counters()->crc_errors);
    ask_axis_count(7);
    check_axis_count();
}

static void exception_is_counted(void)
{
    uint16_t exceptions = traffic_counters()->exceptions;

    PUT(7, 4, 0x0F, 0, 0, 1);
    TEST_ASSERT_EQUAL_UINT16(5, answer());
    TEST_ASSERT_EQUAL_HEX8(0x84, reply[1]);
    TEST_ASSERT_EQUAL_UINT16(exceptions + 1u, traffic_counters()->exceptions);
}

static void overruns_are_counted(void)
{
    uint16_t overruns = traffic_counters()->rx_overruns;

    fake_overrun(3);
    bus_port_poll();
    fake_overrun(200);
    bus_port_poll();
    TEST_ASSERT_EQUAL_UINT16(overruns + 203u, traffic_counters()->rx_overruns);
}

static void broadcast_enables_without_a_reply(void)
{
    uint16_t no_replies = traffic_counters()->no_replies;

    PUT(0, 16, 1, 0, 0, 2, 4, 0, 1, 0, COMMAND_ENABLE);
    TEST_ASSERT_EQUAL_UINT16(0, answer());
    TEST_ASSERT_TRUE(fake_axes[0].enabled);
    TEST_ASSERT_FALSE(fake_axes[1].enabled);
    TEST_ASSERT_EQUAL_UINT16(no_replies + 1u, traffic_counters()->no_replies);
}

// 256 bytes, in parts: a copy of them would not fit the stack of the simulated board.
static void longest_request_is_echoed(void)
{
    static const uint8_t head[] = {7, 8, 0, 0};
    static const uint8_t sum[] = {0x5B, 0xC8};
    uint8_t part[25];

    memset(part, 7, sizeof part);
    fake_receive(head, sizeof head);
    for (uint8_t i = 0; i < 10; i++) {
        fake_receive(part, sizeof part);
    }
    fake_receive(sum, sizeof sum);
    TEST_ASSERT_EQUAL_UINT16(256, answer());
    TEST_ASSERT_EQUAL_HEX8_ARRAY(head, reply, sizeof head);
    for (uint8_t i = 0; i < 10; i++) {
        TEST_ASSERT_EQUAL_HEX8_ARRAY(part, &reply[4 + 25 * i], sizeof part);
    }
    TEST_ASSERT_EQUAL_HEX8_ARRAY(sum, &reply[254], sizeof sum);
    sent();
}

static void listen_only_ends_with_a_restart(void)
{
    PUT(7, 8, 0, 4, 0, 0);
    TEST_ASSERT_EQUAL_UINT16(0, answer());
    TEST_ASSERT_EQUAL_HEX16(0x40, bench_input(REG_INPUT_status) & 0x40u);
    ask_axis_count(7);
    TEST_ASSERT_EQUAL_UINT16(0, answer());
    PUT(7, 8, 0, 1, 0, 0);
    TEST_ASSERT_EQUAL_UINT16(0, answer());
    TEST_ASSERT_EQUAL_HEX16(0, bench_input(REG_INPUT_status) & 0x40u);
    ask_axis_count(7);
    check_axis_count();
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(reply_comes_after_silence);
    RUN_TEST(next_request_is_served);
    RUN_TEST(damaged_request_is_counted);
    RUN_TEST(exception_is_counted);
    RUN_TEST(overruns_are_counted);
    RUN_TEST(broadcast_enables_without_a_reply);
    RUN_TEST(longest_request_is_echoed);
    RUN_TEST(listen_only_ends_with_a_restart);
    return UNITY_END();
}
