// SPDX-License-Identifier: MIT
// A bus with hasty masters: gaps, silences that the main loop missed, bytes that come too early.
#include <stdint.h>
#include <string.h>

#include "bus_bench.h"

static void gaps_within_a_frame_are_tolerated(void)
{
    static const uint8_t request[] = {7, 4, 0, 3, 0, 1};
    uint16_t crc = crc16(request, sizeof request);
    const uint8_t sum[2] = {(uint8_t)crc, (uint8_t)(crc >> 8)};

    for (uint8_t i = 0; i < 8; i++) {
        fake_receive(i < 6 ? &request[i] : &sum[i - 6], 1);
        bus_port_poll();
        fake_pass(SILENCE_TICKS - SLACK_TICKS);
        bus_port_poll();
    }
    check_axis_count();
}

static void silence_within_a_frame_ends_it(void)
{
    static const uint8_t request[] = {7, 4, 0, 3, 0, 1};
    uint16_t errors = traffic_counters()->crc_errors;

    fake_receive(request, 3);
    bus_port_poll();
    fake_pass(SILENCE_TICKS + SLACK_TICKS);
    ask_axis_count(7); // the board looks only now
    check_axis_count();
    TEST_ASSERT_EQUAL_UINT16(errors + 1u, traffic_counters()->crc_errors);
}

static void bytes_before_a_silence_and_after_are_no_frame(void)
{
    static const uint8_t request[] = {7, 4, 0, 3, 0, 1};
    uint16_t crc = crc16(request, sizeof request);
    const uint8_t rest[] = {3, 0, 1, (uint8_t)crc, (uint8_t)(crc >> 8)};

    fake_receive(request, 3);
    fake_pass(SILENCE_TICKS + SLACK_TICKS);
    fake_receive(rest, sizeof rest);
    TEST_ASSERT_EQUAL_UINT16(0, answer());
}

static void request_at_once_behind_a_broadcast_is_served(void)
{
    PUT(0, 16, 1, 0, 0, 2, 4, 0, 3, 0, COMMAND_ENABLE);
    ask_axis_count(7);
    bus_port_poll();
    TEST_ASSERT_TRUE(fake_axes[0].enabled);
    check_axis_count();
}

static void frames_that_waited_are_all_served(void)
{
    for (uint8_t i = 0; i < 4; i++) {
        const uint8_t request[] = {0, 6, 0, 6, 0, (uint8_t)(40 + i)};
        put(request, sizeof request);
        if (i % 2 == 0) {
            fake_pass(SILENCE_TICKS + SLACK_TICKS);
        }
    }
    uint16_t messages = traffic_counters()->bus_messages;
    rounds();
    TEST_ASSERT_EQUAL_UINT16(messages + 4u, traffic_counters()->bus_messages);
    TEST_ASSERT_EQUAL_UINT16(43, bench_settings()->dir_setup_us);
}

static void what_comes_beside_a_reply_is_dropped(void)
{
    PUT(7, 17); // while the reply waits for its checksum
    bus_port_poll();
    PUT(7, 17); // while it is sent
    TEST_ASSERT_EQUAL_UINT16(7, taken());
    TEST_ASSERT_EQUAL_HEX8(4, reply[1]);
    sent();
}

static void what_follows_a_request_belongs_to_nobody(void)
{
    uint16_t messages = traffic_counters()->bus_messages;

    ask_axis_count(7);
    bus_port_poll();
    PUT(0, 6, 0, 6, 0, 99);
    fake_pass(SILENCE_TICKS / 2u);
    PUT(7, 17);
    fake_pass(SILENCE_TICKS / 2u + SLACK_TICKS);
    bus_port_poll();
    bus_port_poll();
    TEST_ASSERT_EQUAL_UINT16(0, taken()); // that broke the silence
    fake_pass(SILENCE_TICKS / 2u);
    bus_port_poll();
    what_comes_beside_a_reply_is_dropped();
    TEST_ASSERT_NOT_EQUAL(99, bench_settings()->dir_setup_us);
    TEST_ASSERT_EQUAL_UINT16(messages + 1u, traffic_counters()->bus_messages);
    ask_axis_count(7);
    check_axis_count();
}

static void overlong_frame_is_dropped(void)
{
    uint8_t bytes[20];
    uint16_t errors = traffic_counters()->crc_errors;

    memset(bytes, 7, sizeof bytes);
    for (uint8_t i = 0; i < 20; i++) {
        fake_receive(bytes, sizeof bytes);
    }
    TEST_ASSERT_EQUAL_UINT16(0, answer());
    TEST_ASSERT_EQUAL_UINT16(errors + 1u, traffic_counters()->crc_errors);
    ask_axis_count(7);
    check_axis_count();
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(gaps_within_a_frame_are_tolerated);
    RUN_TEST(silence_within_a_frame_ends_it);
    RUN_TEST(bytes_before_a_silence_and_after_are_no_frame);
    RUN_TEST(request_at_once_behind_a_broadcast_is_served);
    RUN_TEST(frames_that_waited_are_all_served);
    RUN_TEST(what_follows_a_request_belongs_to_nobody);
    RUN_TEST(overlong_frame_is_dropped);
    return UNITY_END();
}
