// SPDX-License-Identifier: MIT
// The Modbus server: diagnostics, listen-only, identification, files, broadcasts.
#include "server_bench.h"

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

static void check_silent(void)
{
    TEST_ASSERT_EQUAL_UINT16(0, reply_bytes);
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

static void only_a_restart_ends_listen_only(void)
{
    SEND(UNIT, 8, 0, 4, 0, 0);
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

static void files_are_registers(void)
{
    holdings[1] = 0x1111;
    SEND(UNIT, 20, 7, 6, 0, 1, 0, 5, 0, 2);
    CHECK_REPLY(UNIT, 20, 6, 5, 6, 0xA1, 0x05, 0xA1, 0x06);
    SEND(UNIT, 20, 7, 6, 0, 2, 0, 8, 0, 1);
    CHECK_REPLY(UNIT, 20, 4, 3, 6, 0xA3, 0x08);
    SEND(UNIT, 20, 7, 6, 0, 3, 0, FIRST_HOLDING + 1, 0, 1);
    CHECK_REPLY(UNIT, 20, 4, 3, 6, 0x11, 0x11);
}

static void put_file(uint8_t place, uint8_t file, uint16_t record, uint16_t words)
{
    uint8_t *request = &frame.bytes[3u + 7u * place];

    request[0] = 6;
    put_word(&request[1], file);
    put_word(&request[3], record);
    put_word(&request[5], words);
}

static void read_files(uint8_t files)
{
    frame.bytes[0] = UNIT;
    frame.bytes[1] = 20;
    frame.bytes[2] = (uint8_t)(7u * files);
    serve((uint16_t)(3u + 7u * files));
}

// Replies longer than the requests that are still to be served, and shorter.
static void many_files_at_once(void)
{
    for (uint8_t longest = 0; longest < 35; longest++) {
        for (uint8_t i = 0; i < 35; i++) {
            put_file(i, 1, i, i == longest ? 53 : 1);
        }
        read_files(35);
        TEST_ASSERT_EQUAL_UINT16(3 + 34 * 4 + 108 + 2, reply_bytes);
        uint16_t at = 3;
        for (uint8_t i = 0; i < 35; i++) {
            uint8_t words = i == longest ? 53 : 1;
            TEST_ASSERT_EQUAL_UINT8(2u * words + 1u, frame.bytes[at]);
            TEST_ASSERT_EQUAL_UINT8(6, frame.bytes[at + 1u]);
            for (uint8_t word = 0; word < words; word++) {
                TEST_ASSERT_EQUAL_HEX16(0xA100 + i + word,
                                        get_word(&frame.bytes[at + 2u + 2u * word]));
            }
            at = (uint16_t)(at + 2u + 2u * words);
        }
    }
}

static void one_file_as_long_as_fits(void)
{
    put_file(0, 1, 0, 121);
    read_files(1);
    TEST_ASSERT_EQUAL_UINT16(3 + 244 + 2, reply_bytes);
    TEST_ASSERT_EQUAL_UINT8(244, frame.bytes[2]);
    TEST_ASSERT_EQUAL_HEX16(0xA178, get_word(&frame.bytes[245]));
    put_file(0, 1, 0, 122);
    read_files(1);
    check_exception(20, MODBUS_ILLEGAL_VALUE);
}

static void files_exceptions(void)
{
    // Numbers: none, not whole requests, no words, too many of one, of all together.
    SEND(UNIT, 20, 0);
    check_exception(20, MODBUS_ILLEGAL_VALUE);
    SEND(UNIT, 20, 8, 6, 0, 1, 0, 0, 0, 1, 0);
    check_exception(20, MODBUS_ILLEGAL_VALUE);
    SEND(UNIT, 20, 7, 6, 0, 9, 0, 0, 0, 0);
    check_exception(20, MODBUS_ILLEGAL_VALUE);
    SEND(UNIT, 20, 7, 6, 0, 9, 0, 0, 1, 1);
    check_exception(20, MODBUS_ILLEGAL_VALUE);
    put_file(0, 1, 0, 100);
    put_file(1, 9, 0, 22);
    read_files(2);
    check_exception(20, MODBUS_ILLEGAL_VALUE);
    frame.bytes[2] = 252;
    request(UNIT, 20, 0, 0);
    frame.bytes[2] = 252;
    serve(254);
    check_exception(20, MODBUS_ILLEGAL_VALUE);
    // Kind, file, record, its end.
    SEND(UNIT, 20, 7, 5, 0, 1, 0, 0, 0, 1);
    check_exception(20, MODBUS_ILLEGAL_ADDRESS);
    SEND(UNIT, 20, 7, 6, 0, 0, 0, 0, 0, 1);
    check_exception(20, MODBUS_ILLEGAL_ADDRESS);
    SEND(UNIT, 20, 7, 6, 0, 4, 0, 0, 0, 1);
    check_exception(20, MODBUS_ILLEGAL_ADDRESS);
    SEND(UNIT, 20, 7, 6, 1, 1, 0, 0, 0, 1);
    check_exception(20, MODBUS_ILLEGAL_ADDRESS);
    SEND(UNIT, 20, 7, 6, 0, 3, 0x27, 0x10, 0, 1);
    check_exception(20, MODBUS_ILLEGAL_ADDRESS);
    SEND(UNIT, 20, 7, 6, 0, 1, 0, 199, 0, 2);
    check_exception(20, MODBUS_ILLEGAL_ADDRESS);
    SEND(UNIT, 20, 7, 6, 0, 3, 0, 0, 0, 1);
    check_exception(20, MODBUS_ILLEGAL_ADDRESS);
    put_file(0, 1, 0, 1);
    put_file(1, 2, 9, 1);
    read_files(2);
    check_exception(20, MODBUS_ILLEGAL_ADDRESS);
}

static void unknown_functions(void)
{
    static const uint8_t functions[] = {0, 7, 9, 11, 12, 18, 21, 24, 25, 42, 44, 0x7F};

    for (uint8_t i = 0; i < (uint8_t)sizeof functions; i++) {
        ask(functions[i], 0xFFFF, 0);
        check_exception(functions[i], MODBUS_ILLEGAL_FUNCTION);
    }
}

static void busy_is_counted(void)
{
    answer = MODBUS_BUSY;
    ask(6, FIRST_HOLDING, 1);
    TEST_ASSERT_EQUAL_UINT16(1, counters.busy_replies);
    TEST_ASSERT_EQUAL_UINT16(1, counters.exceptions);
    answer = MODBUS_DEVICE_FAILURE;
    ask(6, FIRST_HOLDING, 1);
    TEST_ASSERT_EQUAL_UINT16(1, counters.busy_replies);
    TEST_ASSERT_EQUAL_UINT16(2, counters.exceptions);
    TEST_ASSERT_EQUAL_UINT16(2, counters.frames_ok);
    TEST_ASSERT_EQUAL_UINT16(0, counters.no_replies);
}

static void broadcasts_write_without_a_reply(void)
{
    request(0, 6, FIRST_HOLDING, 0x77);
    serve(6);
    check_silent();
    TEST_ASSERT_EQUAL_HEX16(0x77, holdings[0]);
    write_many(0, FIRST_HOLDING + 1, 2, 4, 2);
    check_silent();
    TEST_ASSERT_EQUAL_HEX16(0x5501, holdings[2]);
    request(0, 5, 3, 0xFF00);
    serve(6);
    check_silent();
    SEND(0, 15, 0, 4, 0, 2, 1, 3);
    check_silent();
    TEST_ASSERT_EQUAL_HEX16(0x38, coils);
    SEND(0, 22, 0, FIRST_HOLDING, 0, 0x0F, 0x12, 0x30);
    check_silent();
    TEST_ASSERT_EQUAL_HEX16(0x1237, holdings[0]);
    TEST_ASSERT_EQUAL_UINT16(5, counters.no_replies);
    TEST_ASSERT_EQUAL_UINT16(5, counters.frames_ok);
}

// Of the bytes behind a broadcast the next frame may have come already.
static void broadcasts_leave_what_follows_alone(void)
{
    static const uint8_t requests[][12] = {
        {6, 0, 5, 3, 0xFF, 0},
        {6, 0, 6, FIRST_HOLDING, 0, 1},
        {8, 0, 15, 0, 0, 0, 2, 1, 3},
        {9, 0, 16, 0, FIRST_HOLDING, 0, 1, 2, 1, 1},
        {8, 0, 22, 0, FIRST_HOLDING, 1, 2, 3, 4},
        {6, 0, 3, 0, FIRST_HOLDING, 0, 100},
        {2, 0, 17},
        {5, 0, 43, 14, 1, 0},
    };

    for (uint8_t i = 0; i < (uint8_t)(sizeof requests / sizeof requests[0]); i++) {
        uint16_t length = requests[i][0];
        memset(frame.bytes, 0xEE, sizeof frame.bytes);
        memcpy(frame.bytes, &requests[i][1], length);
        serve(length);
        for (uint16_t at = (uint16_t)(length + 2u); at < FRAME_MAX_BYTES; at++) {
            TEST_ASSERT_EQUAL_HEX8(0xEE, frame.bytes[at]);
        }
    }
}

static void other_broadcasts_are_silent(void)
{
    static const uint8_t functions[] = {1, 2, 3, 4, 8, 11, 17, 20, 23, 43, 99};

    for (uint8_t i = 0; i < (uint8_t)sizeof functions; i++) {
        request(0, functions[i], 0, 4);
        serve(6);
        check_silent();
    }
    request(0, 6, 0, 1);
    serve(6);
    check_silent();
    TEST_ASSERT_FALSE(counters.listen_only);
    TEST_ASSERT_EQUAL_UINT16(0, counters.exceptions);
    TEST_ASSERT_EQUAL_UINT16(0, writes);
    TEST_ASSERT_EQUAL_UINT16(sizeof functions + 1, counters.no_replies);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(loopback_repeats_the_request);
    RUN_TEST(diagnostic_register_is_the_status);
    RUN_TEST(counters_are_told);
    RUN_TEST(counters_are_cleared);
    RUN_TEST(diagnosis_exceptions);
    RUN_TEST(restart_answers_and_clears);
    RUN_TEST(listen_only_does_nothing);
    RUN_TEST(only_a_restart_ends_listen_only);
    RUN_TEST(device_is_read_from_an_object_on);
    RUN_TEST(device_is_read_by_object);
    RUN_TEST(device_exceptions);
    RUN_TEST(files_are_registers);
    RUN_TEST(many_files_at_once);
    RUN_TEST(one_file_as_long_as_fits);
    RUN_TEST(files_exceptions);
    RUN_TEST(unknown_functions);
    RUN_TEST(busy_is_counted);
    RUN_TEST(broadcasts_write_without_a_reply);
    RUN_TEST(broadcasts_leave_what_follows_alone);
    RUN_TEST(other_broadcasts_are_silent);
    return UNITY_END();
}
