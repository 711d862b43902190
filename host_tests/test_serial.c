// SPDX-License-Identifier: MIT
// The serial line of the fake board: requests in, replies after the silence that ends
// them.
#include <stdint.h>

#include "app/serial.h"
#include "fakes/board.h"
#include "fakes/machine_bench.h"
#include "unity.h"
#include "wire/crc16.h"

#define SILENCE_TICKS (CONFIG_SILENCE_4US * 64u)

static uint8_t reply[32];

void setUp(void)
{
    bench_power_on();
    serial_start(7);
}

// Leave the line as it was found: the server's state outlives a test.
void tearDown(void)
{
    for (uint8_t i = 0; i < 4; i++) {
        fake_pass(SILENCE_TICKS + 64u);
        serial_poll();
    }
    (void)fake_sent(reply, sizeof reply);
}

static void send(const uint8_t *bytes, uint8_t length)
{
    uint16_t crc = crc16(bytes, length);
    uint8_t sum[2] = {(uint8_t)crc, (uint8_t)(crc >> 8)};

    fake_receive(bytes, length);
    fake_receive(sum, 2);
    serial_poll();
}

// The reply is made in one round, sealed and sent in the next.
static uint16_t answer(void)
{
    fake_pass(SILENCE_TICKS + 64u);
    serial_poll();
    serial_poll();
    return fake_sent(reply, sizeof reply);
}

static void ask_axis_count(uint8_t unit)
{
    const uint8_t request[] = {unit, 4, 0, 3, 0, 1};

    send(request, sizeof request);
}

static void reply_comes_after_silence(void)
{
    ask_axis_count(7);
    TEST_ASSERT_EQUAL_UINT16(0, fake_sent(reply, sizeof reply));
    fake_pass(SILENCE_TICKS - 1000u);
    serial_poll();
    TEST_ASSERT_EQUAL_UINT16(0, fake_sent(reply, sizeof reply));
    TEST_ASSERT_EQUAL_UINT16(7, answer());
    TEST_ASSERT_EQUAL_HEX8(7, reply[0]);
    TEST_ASSERT_EQUAL_UINT8(CONFIG_AXES, reply[4]);
    TEST_ASSERT_EQUAL_HEX16(0, crc16(reply, 7));
}

static void next_request_is_served(void)
{
    for (uint8_t i = 0; i < 3; i++) {
        ask_axis_count(7);
        TEST_ASSERT_EQUAL_UINT16(7, answer());
        fake_pass(200000uL);
        serial_poll();
    }
}

static void foreign_request_has_no_reply(void)
{
    uint16_t errors = serial_counters()->crc_errors;

    ask_axis_count(8);
    TEST_ASSERT_EQUAL_UINT16(0, answer());
    TEST_ASSERT_EQUAL_UINT16(errors, serial_counters()->crc_errors);
    ask_axis_count(7);
    TEST_ASSERT_EQUAL_UINT16(7, answer());
}

static void damaged_request_is_counted(void)
{
    static const uint8_t request[] = {7, 4, 0, 3, 0, 1, 0x11, 0x22};
    uint16_t errors = serial_counters()->crc_errors;

    fake_receive(request, sizeof request);
    serial_poll();
    TEST_ASSERT_EQUAL_UINT16(0, answer());
    TEST_ASSERT_EQUAL_UINT16(errors + 1u, serial_counters()->crc_errors);
    ask_axis_count(7);
    TEST_ASSERT_EQUAL_UINT16(7, answer());
}

static void exception_is_counted(void)
{
    static const uint8_t request[] = {7, 4, 0x0F, 0, 0, 1};
    uint16_t exceptions = serial_counters()->exceptions;

    send(request, sizeof request);
    TEST_ASSERT_EQUAL_UINT16(5, answer());
    TEST_ASSERT_EQUAL_HEX8(0x84, reply[1]);
    TEST_ASSERT_EQUAL_UINT16(exceptions + 1u, serial_counters()->exceptions);
}

static void broadcast_enables_without_a_reply(void)
{
    static const uint8_t request[] = {0, 16, 1, 0, 0, 2, 4, 0, 3, 0, COMMAND_ENABLE};

    send(request, sizeof request);
    TEST_ASSERT_EQUAL_UINT16(0, answer());
    TEST_ASSERT_TRUE(fake_axes[0].enabled && fake_axes[1].enabled);
    TEST_ASSERT_FALSE(fake_axes[2].enabled);
}

static void settings_are_busy_while_moving(void)
{
    static const uint8_t request[] = {7, 6, 0, 6, 0, 50};

    bench_plain_line(0, 10, 20);
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(1, COMMAND_ARM));
    send(request, sizeof request);
    TEST_ASSERT_EQUAL_UINT16(5, answer());
    TEST_ASSERT_EQUAL_HEX8(0x86, reply[1]);
    TEST_ASSERT_EQUAL_HEX8(MODBUS_BUSY, reply[2]);
}

static void new_address_counts_from_the_next_request(void)
{
    static const uint8_t request[] = {7, 6, 0, 0, 0, 9};

    send(request, sizeof request);
    TEST_ASSERT_EQUAL_UINT16(8, answer());
    TEST_ASSERT_EQUAL_HEX8(7, reply[0]);
    fake_pass(200000uL);
    serial_poll();
    ask_axis_count(9);
    TEST_ASSERT_EQUAL_UINT16(7, answer());
    TEST_ASSERT_EQUAL_HEX8(9, reply[0]);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(reply_comes_after_silence);
    RUN_TEST(next_request_is_served);
    RUN_TEST(foreign_request_has_no_reply);
    RUN_TEST(damaged_request_is_counted);
    RUN_TEST(exception_is_counted);
    RUN_TEST(broadcast_enables_without_a_reply);
    RUN_TEST(settings_are_busy_while_moving);
    RUN_TEST(new_address_counts_from_the_next_request);
    return UNITY_END();
}
