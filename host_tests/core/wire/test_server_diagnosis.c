// SPDX-License-Identifier: MIT
// The Modbus server's reports about itself: diagnosis, listen-only mode, identification.
#include <stdint.h>
#include <string.h>

#include "server_bench.h"

static void identify(void)
{
    SEND(UNIT, 17);
    CHECK_REPLY(UNIT, 17, 11, 42, 0x00, 'm', 'e', ' ', 'b', '1', ' ', '0', '.', '7');
    running = true;
    SEND(UNIT, 17);
    TEST_ASSERT_EQUAL_HEX8(0xFF, frame.bytes[4]);
    SEND(UNIT, 17, 0);
    check_exception(17, MODBUS_ILLEGAL_VALUE);
}

static void loopback_repeats_the_request(void)
{
    SEND(UNIT, 8, 0, 0, 0xBE, 0xEF);
    CHECK_REPLY(UNIT, 8, 0, 0, 0xBE, 0xEF);
    SEND(UNIT, 8, 0, 0, 1, 2, 3, 4, 5, 6);
    CHECK_REPLY(UNIT, 8, 0, 0, 1, 2, 3, 4, 5, 6);
    SEND(UNIT, 8, 0, 0);
    CHECK_REPLY(UNIT, 8, 0, 0);
}

static void diagnostic_register_is_the_status(void)
{
    SEND(UNIT, 8, 0, 2, 0, 0);
    CHECK_REPLY(UNIT, 8, 0, 2, 0xA0, REG_INPUT_status);
}

static void counters_are_told(void)
{
    counters = (struct server_counters){.bus_messages = 0x1101,
                                        .crc_errors = 0x1202,
                                        .frames_ok = 0x1404,
                                        .no_replies = 0x1505,
                                        .busy_replies = 0x1707,
                                        .rx_overruns = 0x1808};
    for (uint8_t i = 11; i <= 18; i++) {
        uint8_t expected = (uint8_t)(i - 10u);
        SEND(UNIT, 8, 0, i, 0, 0);
        TEST_ASSERT_EQUAL_UINT16(8, reply_bytes);
        uint16_t told = get_word(&frame.bytes[4]);
        if (i == 13 || i == 16) { // exceptions were set to none, NAKs there are none
            TEST_ASSERT_EQUAL_HEX16(0, told);
        } else if (i == 14) { // this one and those before it
            TEST_ASSERT_EQUAL_HEX16(0x1404 + 4, told);
        } else {
            TEST_ASSERT_EQUAL_HEX16(0x1000u + 0x100u * expected + expected, told);
        }
    }
}

static void counters_are_cleared(void)
{
    memset(&counters.all, 0x55, sizeof counters.all);
    SEND(UNIT, 8, 0, 10, 0, 0);
    CHECK_REPLY(UNIT, 8, 0, 10, 0, 0);
    for (uint8_t i = 0; i < SERVER_COUNTERS; i++) {
        TEST_ASSERT_EQUAL_UINT16(0, counters.all[i]);
    }
}

static void diagnosis_exceptions(void)
{
    static const uint8_t unknown[] = {3, 5, 6, 7, 8, 9, 19, 20, 255};
    static const uint8_t empty[] = {2, 4, 10, 11, 18};

    for (uint8_t i = 0; i < (uint8_t)(sizeof unknown); i++) {
        SEND(UNIT, 8, 0, unknown[i], 0, 0);
        check_exception(8, MODBUS_ILLEGAL_FUNCTION);
    }
    SEND(UNIT, 8, 1, 2, 0, 0);
    check_exception(8, MODBUS_ILLEGAL_FUNCTION);
    for (uint8_t i = 0; i < (uint8_t)(sizeof empty); i++) {
        SEND(UNIT, 8, 0, empty[i], 0, 1);
        check_exception(8, MODBUS_ILLEGAL_VALUE);
        SEND(UNIT, 8, 0, empty[i], 0xFF, 0);
        check_exception(8, MODBUS_ILLEGAL_VALUE);
        SEND(UNIT, 8, 0, empty[i]);
        check_exception(8, MODBUS_ILLEGAL_VALUE);
    }
    SEND(UNIT, 8, 0, 1, 0xFE, 0);
    check_exception(8, MODBUS_ILLEGAL_VALUE);
    SEND(UNIT, 8, 0, 1, 0xFF, 1);
    check_exception(8, MODBUS_ILLEGAL_VALUE);
    TEST_ASSERT_FALSE(counters.listen_only);
}

static void restart_answers_and_clears(void)
{
    memset(&counters.all, 0x55, sizeof counters.all);
    SEND(UNIT, 8, 0, 1, 0xFF, 0);
    CHECK_REPLY(UNIT, 8, 0, 1, 0xFF, 0);
    TEST_ASSERT_EQUAL_UINT16(0, counters.crc_errors);
    SEND(UNIT, 8, 0, 1, 0, 0);
    CHECK_REPLY(UNIT, 8, 0, 1, 0, 0);
}

static void listen_only_does_nothing(void)
{
    SEND(UNIT, 8, 0, 4, 0, 0);
    check_silent();
    TEST_ASSERT_TRUE(counters.listen_only);
    TEST_ASSERT_EQUAL_UINT16(1, counters.no_replies);
    ask(4, 3, 2);
    check_silent();
    ask(6, FIRST_HOLDING, 0x77);
    check_silent();
    request(0, 6, FIRST_HOLDING, 0x77);
    serve(6);
    check_silent();
    SEND(UNIT, 8, 0, 0, 1, 2);
    check_silent();
    SEND(UNIT, 8, 0, 10, 0, 0);
    check_silent();
    SEND(UNIT, 99);
    check_silent();
    TEST_ASSERT_EQUAL_UINT16(0, writes);
    TEST_ASSERT_EQUAL_UINT16(7, counters.no_replies);
    TEST_ASSERT_EQUAL_UINT16(7, counters.frames_ok);
    TEST_ASSERT_EQUAL_UINT16(0, counters.exceptions);
}

static void listen_only_ends_with_a_restart(void)
{
    counters.listen_only = true;
    SEND(0, 8, 0, 1, 0, 0); // to all: not one of what all may be told
    check_silent();
    SEND(UNIT, 8, 1, 1, 0, 0);
    check_silent();
    SEND(UNIT, 8, 0, 1, 0, 7);
    check_silent();
    TEST_ASSERT_TRUE(counters.listen_only);
    SEND(UNIT, 8, 0, 1, 0, 0);
    check_silent();
    TEST_ASSERT_FALSE(counters.listen_only);
    TEST_ASSERT_EQUAL_UINT16(0, counters.frames_ok);
    TEST_ASSERT_EQUAL_UINT16(1, counters.no_replies); // the restart itself
    ask(4, 3, 2);
    check_words(2, 0xA003);
}

static void device_is_read_from_an_object_on(void)
{
    for (uint8_t code = 1; code <= 3; code++) {
        SEND(UNIT, 43, 14, code, 0);
        CHECK_REPLY(UNIT,
                    43,
                    14,
                    code,
                    0x81,
                    0,
                    0,
                    3,
                    0,
                    2,
                    'm',
                    'e',
                    1,
                    2,
                    'b',
                    '1',
                    2,
                    3,
                    '0',
                    '.',
                    '7');
        SEND(UNIT, 43, 14, code, 2);
        CHECK_REPLY(UNIT, 43, 14, code, 0x81, 0, 0, 1, 2, 3, '0', '.', '7');
        // One that is not there: from the first on.
        SEND(UNIT, 43, 14, code, 3);
        TEST_ASSERT_EQUAL_UINT8(3, frame.bytes[7]);
        TEST_ASSERT_EQUAL_UINT8(0, frame.bytes[8]);
    }
}

static void device_is_read_by_object(void)
{
    SEND(UNIT, 43, 14, 4, 0);
    CHECK_REPLY(UNIT, 43, 14, 4, 0x81, 0, 0, 1, 0, 2, 'm', 'e');
    SEND(UNIT, 43, 14, 4, 1);
    CHECK_REPLY(UNIT, 43, 14, 4, 0x81, 0, 0, 1, 1, 2, 'b', '1');
    SEND(UNIT, 43, 14, 4, 2);
    CHECK_REPLY(UNIT, 43, 14, 4, 0x81, 0, 0, 1, 2, 3, '0', '.', '7');
}

static void device_exceptions(void)
{
    SEND(UNIT, 43, 13, 1, 0);
    check_exception(43, MODBUS_ILLEGAL_FUNCTION);
    SEND(UNIT, 43, 14, 0, 0);
    check_exception(43, MODBUS_ILLEGAL_VALUE);
    SEND(UNIT, 43, 14, 5, 0);
    check_exception(43, MODBUS_ILLEGAL_VALUE);
    SEND(UNIT, 43, 14, 4, 3);
    check_exception(43, MODBUS_ILLEGAL_ADDRESS);
    SEND(UNIT, 43, 14, 1);
    check_exception(43, MODBUS_ILLEGAL_VALUE);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(identify);
    RUN_TEST(loopback_repeats_the_request);
    RUN_TEST(diagnostic_register_is_the_status);
    RUN_TEST(counters_are_told);
    RUN_TEST(counters_are_cleared);
    RUN_TEST(diagnosis_exceptions);
    RUN_TEST(restart_answers_and_clears);
    RUN_TEST(listen_only_does_nothing);
    RUN_TEST(listen_only_ends_with_a_restart);
    RUN_TEST(device_is_read_from_an_object_on);
    RUN_TEST(device_is_read_by_object);
    RUN_TEST(device_exceptions);
    return UNITY_END();
}
