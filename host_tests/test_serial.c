// SPDX-License-Identifier: MIT
// The serial line of the fake board: requests in, replies after the silence that ends them, and
// everything else that goes over a line with several boards.
#include <stdint.h>
#include <string.h>

#include "app/serial.h"
#include "fakes/board.h"
#include "fakes/machine_bench.h"
#include "hal/uart.h"
#include "unity.h"
#include "wire/baud.h"
#include "wire/crc16.h"
#include "wire/register_map.h"

#define MS_TICKS      16000u
#define SILENCE_TICKS ((uint32_t)fake_line.silence_16us * 256u)
#define SLACK_TICKS   256u

static uint8_t reply[UART_BUFFER_BYTES];

void setUp(void)
{
    bench_power_on();
    serial_start(7);
    fake_pass(SILENCE_TICKS);
}

// Leave the line as it was found: the server's state outlives a test.
void tearDown(void)
{
    for (uint8_t i = 0; i < 4; i++) {
        fake_pass((uint32_t)30 * MS_TICKS);
        serial_poll();
    }
    (void)fake_sent(reply, sizeof reply);
}

static void put(const uint8_t *bytes, uint8_t length)
{
    uint16_t crc = crc16(bytes, length);
    uint8_t sum[2] = {(uint8_t)crc, (uint8_t)(crc >> 8)};

    fake_receive(bytes, length);
    fake_receive(sum, 2);
}

#define PUT(...)                                                                         \
    put((const uint8_t[]){__VA_ARGS__}, (uint8_t)sizeof(const uint8_t[]){__VA_ARGS__})

static uint16_t taken(void)
{
    return fake_sent(reply, sizeof reply);
}

// The reply is made in one round, sealed and sent in the next.
static uint16_t answer(void)
{
    serial_poll();
    fake_pass(SILENCE_TICKS + SLACK_TICKS);
    serial_poll();
    serial_poll();
    return taken();
}

// Until the reply has left.
static void sent(void)
{
    fake_pass((uint32_t)400 * MS_TICKS);
    serial_poll();
}

static void ask_axis_count(uint8_t unit)
{
    PUT(unit, 4, 0, 3, 0, 1);
}

static void check_axis_count(void)
{
    TEST_ASSERT_EQUAL_UINT16(7, answer());
    TEST_ASSERT_EQUAL_HEX8(7, reply[0]);
    TEST_ASSERT_EQUAL_HEX8(4, reply[1]);
    TEST_ASSERT_EQUAL_UINT8(CONFIG_AXES, reply[4]);
    TEST_ASSERT_EQUAL_HEX16(0, crc16(reply, 7));
    sent();
}

static void reply_comes_after_silence(void)
{
    ask_axis_count(7);
    serial_poll();
    TEST_ASSERT_EQUAL_UINT16(0, taken());
    fake_pass(SILENCE_TICKS - SLACK_TICKS);
    serial_poll();
    serial_poll();
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

static void gaps_within_a_frame_are_tolerated(void)
{
    static const uint8_t request[] = {7, 4, 0, 3, 0, 1};
    uint16_t crc = crc16(request, sizeof request);
    const uint8_t sum[2] = {(uint8_t)crc, (uint8_t)(crc >> 8)};

    for (uint8_t i = 0; i < 8; i++) {
        fake_receive(i < 6 ? &request[i] : &sum[i - 6], 1);
        serial_poll();
        fake_pass(SILENCE_TICKS - SLACK_TICKS);
        serial_poll();
    }
    check_axis_count();
}

static void silence_within_a_frame_ends_it(void)
{
    static const uint8_t request[] = {7, 4, 0, 3, 0, 1};
    uint16_t errors = serial_counters()->crc_errors;

    fake_receive(request, 3);
    serial_poll();
    fake_pass(SILENCE_TICKS + SLACK_TICKS);
    ask_axis_count(7); // the board looks only now
    check_axis_count();
    TEST_ASSERT_EQUAL_UINT16(errors + 1u, serial_counters()->crc_errors);
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

static void foreign_request_has_no_reply(void)
{
    uint16_t errors = serial_counters()->crc_errors;
    uint16_t messages = serial_counters()->bus_messages;
    uint16_t ok = serial_counters()->frames_ok;

    ask_axis_count(8);
    TEST_ASSERT_EQUAL_UINT16(0, answer());
    TEST_ASSERT_EQUAL_UINT16(errors, serial_counters()->crc_errors);
    TEST_ASSERT_EQUAL_UINT16(messages + 1u, serial_counters()->bus_messages);
    TEST_ASSERT_EQUAL_UINT16(ok, serial_counters()->frames_ok);
    ask_axis_count(7);
    check_axis_count();
    TEST_ASSERT_EQUAL_UINT16(messages + 2u, serial_counters()->bus_messages);
    TEST_ASSERT_EQUAL_UINT16(ok + 1u, serial_counters()->frames_ok);
}

// A request to another board, its reply and our request, without a silence anywhere.
static void request_behind_foreign_frames_is_served(void)
{
    uint16_t messages = serial_counters()->bus_messages;

    ask_axis_count(8);
    PUT(8, 4, 2, 0, 4);
    PUT(9, 3, 0, 0, 0, 2);
    PUT(9, 0x83, 2);
    PUT(9, 6, 0, 6, 0, 50);
    PUT(9, 6, 0, 6, 0, 50);
    PUT(9, 17);
    PUT(9, 17, 3, 7, 255, 'x');
    ask_axis_count(7);
    check_axis_count();
    TEST_ASSERT_EQUAL_UINT16(messages + 9u, serial_counters()->bus_messages);
}

// Whatever a foreign reply carries, a whole frame for us among it.
static void foreign_reply_executes_nothing(void)
{
    uint16_t setup_us = machine.settings.dir_setup_us;
    uint8_t carrier[3 + 8 + 1] = {9, 3, 9, 7, 6, 0, 6, 0, 77};
    uint16_t crc = crc16(&carrier[3], 6);

    carrier[9] = (uint8_t)crc;
    carrier[10] = (uint8_t)(crc >> 8);
    put(carrier, sizeof carrier);
    TEST_ASSERT_EQUAL_UINT16(0, answer());
    TEST_ASSERT_EQUAL_UINT16(setup_us, machine.settings.dir_setup_us);
    ask_axis_count(7);
    check_axis_count();
}

static void frame_of_unknown_length_is_over_with_silence(void)
{
    PUT(9, 43, 14, 1, 0x81, 0, 0, 1, 0, 1, 'x');
    serial_poll();
    fake_pass(SILENCE_TICKS + SLACK_TICKS);
    ask_axis_count(7);
    check_axis_count();
}

static void damaged_request_is_counted(void)
{
    static const uint8_t request[] = {7, 4, 0, 3, 0, 1, 0x11, 0x22};
    uint16_t errors = serial_counters()->crc_errors;

    fake_receive(request, sizeof request);
    TEST_ASSERT_EQUAL_UINT16(0, answer());
    TEST_ASSERT_EQUAL_UINT16(errors + 1u, serial_counters()->crc_errors);
    ask_axis_count(7);
    check_axis_count();
}

static void exception_is_counted(void)
{
    uint16_t exceptions = serial_counters()->exceptions;

    PUT(7, 4, 0x0F, 0, 0, 1);
    TEST_ASSERT_EQUAL_UINT16(5, answer());
    TEST_ASSERT_EQUAL_HEX8(0x84, reply[1]);
    TEST_ASSERT_EQUAL_UINT16(exceptions + 1u, serial_counters()->exceptions);
}

static void overruns_are_counted(void)
{
    uint16_t overruns = serial_counters()->rx_overruns;

    fake_overrun(3);
    serial_poll();
    fake_overrun(200);
    serial_poll();
    TEST_ASSERT_EQUAL_UINT16(overruns + 203u, serial_counters()->rx_overruns);
}

static void broadcast_enables_without_a_reply(void)
{
    uint16_t no_replies = serial_counters()->no_replies;

    PUT(0, 16, 1, 0, 0, 2, 4, 0, 3, 0, COMMAND_ENABLE);
    TEST_ASSERT_EQUAL_UINT16(0, answer());
    TEST_ASSERT_TRUE(fake_axes[0].enabled && fake_axes[1].enabled);
    TEST_ASSERT_FALSE(fake_axes[2].enabled);
    TEST_ASSERT_EQUAL_UINT16(no_replies + 1u, serial_counters()->no_replies);
}

static void request_at_once_behind_a_broadcast_is_served(void)
{
    PUT(0, 16, 1, 0, 0, 2, 4, 0, 3, 0, COMMAND_ENABLE);
    ask_axis_count(7);
    serial_poll();
    TEST_ASSERT_TRUE(fake_axes[0].enabled);
    check_axis_count();
}

// Behind a silence that nobody saw, with more of them to come.
static void frames_that_waited_are_all_served(void)
{
    for (uint8_t i = 0; i < 4; i++) {
        PUT(0, 6, 0, 6, 0, (uint8_t)(40 + i));
        if (i % 2 == 0) {
            fake_pass(SILENCE_TICKS + SLACK_TICKS);
        }
    }
    uint16_t messages = serial_counters()->bus_messages;
    serial_poll();
    TEST_ASSERT_EQUAL_UINT16(messages + 4u, serial_counters()->bus_messages);
    TEST_ASSERT_EQUAL_UINT16(43, machine.settings.dir_setup_us);
}

static void what_follows_a_request_belongs_to_nobody(void)
{
    uint16_t messages = serial_counters()->bus_messages;

    ask_axis_count(7);
    serial_poll();
    PUT(0, 6, 0, 6, 0, 99);
    fake_pass(SILENCE_TICKS / 2u);
    PUT(7, 17);
    fake_pass(SILENCE_TICKS / 2u + SLACK_TICKS);
    serial_poll();
    serial_poll();
    TEST_ASSERT_EQUAL_UINT16(0, taken()); // that broke the silence
    fake_pass(SILENCE_TICKS / 2u);
    serial_poll();
    PUT(7, 17); // while the reply waits for its checksum
    serial_poll();
    PUT(7, 17); // while it is sent
    TEST_ASSERT_EQUAL_UINT16(7, taken());
    TEST_ASSERT_EQUAL_HEX8(4, reply[1]);
    sent();
    TEST_ASSERT_NOT_EQUAL(99, machine.settings.dir_setup_us);
    TEST_ASSERT_EQUAL_UINT16(messages + 1u, serial_counters()->bus_messages);
    ask_axis_count(7);
    check_axis_count();
}

static void longest_request_is_echoed(void)
{
    uint8_t bytes[254] = {7, 8, 0, 0};

    for (uint8_t i = 4; i < sizeof bytes; i++) {
        bytes[i] = i;
    }
    put(bytes, sizeof bytes);
    TEST_ASSERT_EQUAL_UINT16(256, answer());
    TEST_ASSERT_EQUAL_HEX8_ARRAY(bytes, reply, sizeof bytes);
    sent();
}

static void overlong_frame_is_dropped(void)
{
    uint8_t bytes[200];
    uint16_t errors = serial_counters()->crc_errors;

    memset(bytes, 7, sizeof bytes);
    fake_receive(bytes, sizeof bytes);
    fake_receive(bytes, sizeof bytes);
    TEST_ASSERT_EQUAL_UINT16(0, answer());
    TEST_ASSERT_EQUAL_UINT16(errors + 1u, serial_counters()->crc_errors);
    ask_axis_count(7);
    check_axis_count();
}

static void reply_delay_comes_on_top(void)
{
    machine.settings.reply_delay_us = 5000;
    ask_axis_count(7);
    TEST_ASSERT_EQUAL_UINT16(0, answer());
    fake_pass((uint32_t)4 * MS_TICKS);
    serial_poll();
    TEST_ASSERT_EQUAL_UINT16(0, taken());
    fake_pass(MS_TICKS);
    serial_poll();
    TEST_ASSERT_EQUAL_UINT16(7, taken());
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
    TEST_ASSERT_EQUAL_UINT8(baud_divisor(1152), fake_line.divisor);
    TEST_ASSERT_EQUAL(UART_EVEN, fake_line.parity);
    TEST_ASSERT_EQUAL_UINT16(baud_silence_16us(17), fake_line.silence_16us);
    TEST_ASSERT_EQUAL_UINT8(1, fake_line.changes);
}

static void new_rate_counts_when_the_reply_has_left(void)
{
    PUT(7, 6, 0, 1, 0, 96);
    TEST_ASSERT_EQUAL_UINT16(8, answer());
    serial_poll();
    TEST_ASSERT_EQUAL_UINT8(baud_divisor(1152), fake_line.divisor);
    sent();
    TEST_ASSERT_EQUAL_UINT8(208, fake_line.divisor);
    TEST_ASSERT_EQUAL_UINT16(baud_silence_16us(208), fake_line.silence_16us);
    ask_axis_count(7);
    check_axis_count();
    TEST_ASSERT_EQUAL_UINT8(2, fake_line.changes);
}

static void new_parity_of_all_counts_at_once(void)
{
    PUT(0, 6, 0, 13, 0, 1);
    serial_poll();
    TEST_ASSERT_EQUAL(UART_ODD, fake_line.parity);
    ask_axis_count(7);
    check_axis_count();
}

static void last_request_is_ours_or_everybodys(void)
{
    fake_pass((uint32_t)100 * MS_TICKS);
    uint16_t before = serial_last_request_ms();
    ask_axis_count(8);
    serial_poll();
    TEST_ASSERT_EQUAL_UINT16(before, serial_last_request_ms());
    PUT(0, 3, 0, 0, 0, 1);
    serial_poll();
    TEST_ASSERT_EQUAL_UINT16(fake_now_ticks() / 16384u, serial_last_request_ms());
    fake_pass((uint32_t)100 * MS_TICKS);
    ask_axis_count(7);
    check_axis_count();
    TEST_ASSERT_TRUE(serial_last_request_ms() >= 195);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(reply_comes_after_silence);
    RUN_TEST(next_request_is_served);
    RUN_TEST(gaps_within_a_frame_are_tolerated);
    RUN_TEST(silence_within_a_frame_ends_it);
    RUN_TEST(bytes_before_a_silence_and_after_are_no_frame);
    RUN_TEST(foreign_request_has_no_reply);
    RUN_TEST(request_behind_foreign_frames_is_served);
    RUN_TEST(foreign_reply_executes_nothing);
    RUN_TEST(frame_of_unknown_length_is_over_with_silence);
    RUN_TEST(damaged_request_is_counted);
    RUN_TEST(exception_is_counted);
    RUN_TEST(overruns_are_counted);
    RUN_TEST(broadcast_enables_without_a_reply);
    RUN_TEST(request_at_once_behind_a_broadcast_is_served);
    RUN_TEST(frames_that_waited_are_all_served);
    RUN_TEST(what_follows_a_request_belongs_to_nobody);
    RUN_TEST(longest_request_is_echoed);
    RUN_TEST(overlong_frame_is_dropped);
    RUN_TEST(reply_delay_comes_on_top);
    RUN_TEST(listen_only_ends_with_a_restart);
    RUN_TEST(settings_are_busy_while_moving);
    RUN_TEST(new_address_counts_from_the_next_request);
    RUN_TEST(line_begins_with_the_settings);
    RUN_TEST(new_rate_counts_when_the_reply_has_left);
    RUN_TEST(new_parity_of_all_counts_at_once);
    RUN_TEST(last_request_is_ours_or_everybodys);
    return UNITY_END();
}
