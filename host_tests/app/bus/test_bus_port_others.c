// SPDX-License-Identifier: MIT
// A bus with other boards: their requests and replies.
#include <stdint.h>

#include "bus_bench.h"

static void foreign_request_has_no_reply(void)
{
    uint16_t errors = traffic_counters()->crc_errors;
    uint16_t messages = traffic_counters()->bus_messages;
    uint16_t ok = traffic_counters()->frames_ok;

    ask_axis_count(8);
    TEST_ASSERT_EQUAL_UINT16(0, answer());
    TEST_ASSERT_EQUAL_UINT16(errors, traffic_counters()->crc_errors);
    TEST_ASSERT_EQUAL_UINT16(messages + 1u, traffic_counters()->bus_messages);
    TEST_ASSERT_EQUAL_UINT16(ok, traffic_counters()->frames_ok);
    ask_axis_count(7);
    check_axis_count();
    TEST_ASSERT_EQUAL_UINT16(messages + 2u, traffic_counters()->bus_messages);
    TEST_ASSERT_EQUAL_UINT16(ok + 1u, traffic_counters()->frames_ok);
}

// Requests and replies by every rule of length.
static void others_talk(void)
{
    ask_axis_count(8);
    PUT(8, 4, 2, 0, 4);
    PUT(9, 3, 0, 0, 0, 2);
    PUT(9, 0x83, 2);
    PUT(9, 6, 0, 6, 0, 50);
    PUT(9, 6, 0, 6, 0, 50);
    PUT(9, 17);
    PUT(9, 17, 3, 7, 255, 'x');
}

static void request_behind_foreign_frames_is_served(void)
{
    uint16_t messages = traffic_counters()->bus_messages;

    others_talk();
    ask_axis_count(7);
    for (uint8_t i = 0; i < 8; i++) { // one a round
        bus_port_poll();
    }
    check_axis_count();
    TEST_ASSERT_EQUAL_UINT16(messages + 9u, traffic_counters()->bus_messages);
}

static void foreign_reply_executes_nothing(void)
{
    uint16_t setup_us = bench_settings()->dir_setup_us;
    uint8_t carrier[3 + 8 + 1] = {9, 3, 9, 7, 6, 0, 6, 0, 77};
    uint16_t crc = crc16(&carrier[3], 6);

    carrier[9] = (uint8_t)crc;
    carrier[10] = (uint8_t)(crc >> 8);
    put(carrier, sizeof carrier);
    TEST_ASSERT_EQUAL_UINT16(0, answer());
    TEST_ASSERT_EQUAL_UINT16(setup_us, bench_settings()->dir_setup_us);
    ask_axis_count(7);
    check_axis_count();
}

static void frame_of_unknown_length_is_over_with_silence(void)
{
    PUT(9, 43, 14, 1, 0x81, 0, 0, 1, 0, 1, 'x');
    bus_port_poll();
    fake_pass(SILENCE_TICKS + SLACK_TICKS);
    ask_axis_count(7);
    check_axis_count();
}

// The silence behind it is over, and none follows yet.
static void frame_behind_a_bad_one_is_served_at_once(void)
{
    static const uint8_t noise[30] = {7, 16, 1, 0, 0, 2, 4};
    uint16_t errors = traffic_counters()->crc_errors;
    uint16_t messages = traffic_counters()->bus_messages;

    fake_receive(noise, sizeof noise);
    bus_port_poll();
    fake_pass(SILENCE_TICKS + SLACK_TICKS);
    PUT(0, 16, 1, 0, 0, 2, 4, 0, 2, 0, COMMAND_ENABLE);
    ask_axis_count(7);
    bus_port_poll();
    TEST_ASSERT_EQUAL_UINT16(errors + 1u, traffic_counters()->crc_errors);
    bus_port_poll();
    TEST_ASSERT_TRUE(fake_axes[1].enabled);
    bus_port_poll();
    TEST_ASSERT_EQUAL_UINT16(messages + 2u, traffic_counters()->bus_messages);
    check_axis_count();
    TEST_ASSERT_EQUAL_UINT16(errors + 1u, traffic_counters()->crc_errors);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(foreign_request_has_no_reply);
    RUN_TEST(request_behind_foreign_frames_is_served);
    RUN_TEST(foreign_reply_executes_nothing);
    RUN_TEST(frame_behind_a_bad_one_is_served_at_once);
    RUN_TEST(frame_of_unknown_length_is_over_with_silence);
    return UNITY_END();
}
