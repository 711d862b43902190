// SPDX-License-Identifier: MIT
// The Modbus server over a few registers: replies, and exceptions in the standard's order.
#include <stdint.h>
#include <string.h>

#include "server_bench.h"

static void read_inputs(void)
{
    ask(4, 3, 2);
    check_words(2, 0xA003);
    TEST_ASSERT_EQUAL_HEX8(4, frame.bytes[1]);
}

static void read_as_much_as_fits(void)
{
    ask(4, 1, 125);
    check_words(125, 0xA001);
}

// The board has some of these registers together.
static void read_records(void)
{
    for (uint8_t count = 1; count <= 125u; count++) {
        ask(4, (uint16_t)(RECORDS + count / 2u), count);
        check_words(count, (uint16_t)(0xA000u + RECORDS + count / 2u));
    }
}

static void read_holdings(void)
{
    holdings[4] = 0x1234;
    holdings[5] = 0x1235;
    ask(3, FIRST_HOLDING + 4, 2);
    check_words(2, 0x1234);
    TEST_ASSERT_EQUAL_UINT16(0, counters.exceptions);
}

static void check_read_exceptions(uint8_t function, uint16_t good_address)
{
    ask(function, good_address, 0);
    check_exception(function, MODBUS_ILLEGAL_VALUE);
    ask(function, good_address, 126);
    check_exception(function, MODBUS_ILLEGAL_VALUE);
    ask(function, 0xFFFF, 1);
    check_exception(function, MODBUS_ILLEGAL_ADDRESS);
    ask(function, 0xFFFF, 2);
    check_exception(function, MODBUS_ILLEGAL_ADDRESS);
    // Both are wrong: the quantity is checked first.
    ask(function, 0xFFFF, 126);
    check_exception(function, MODBUS_ILLEGAL_VALUE);
    request(UNIT, function, good_address, 1);
    serve(7);
    check_exception(function, MODBUS_ILLEGAL_VALUE);
    request(UNIT, function, good_address, 1);
    serve(5);
    check_exception(function, MODBUS_ILLEGAL_VALUE);
}

static void read_exceptions(void)
{
    check_read_exceptions(3, FIRST_HOLDING);
    check_read_exceptions(4, 0);
    ask(4, 125, 2);
    check_exception(4, MODBUS_ILLEGAL_ADDRESS);
    TEST_ASSERT_EQUAL_UINT16(0, writes);
}

static void write_one_echoes(void)
{
    static const uint8_t echo[] = {UNIT, 6, 0, FIRST_HOLDING + 2, 0xBE, 0xEF};

    ask(6, FIRST_HOLDING + 2, 0xBEEF);
    TEST_ASSERT_EQUAL_UINT16(8, reply_bytes);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(echo, frame.bytes, sizeof echo);
    TEST_ASSERT_EQUAL_HEX16(0xBEEF, holdings[2]);
}

static void write_one_exceptions(void)
{
    ask(6, 0, 1);
    check_exception(6, MODBUS_ILLEGAL_ADDRESS);
    request(UNIT, 6, FIRST_HOLDING, 1);
    serve(4);
    check_exception(6, MODBUS_ILLEGAL_VALUE);
    TEST_ASSERT_EQUAL_UINT16(0, writes);
    answer = MODBUS_BUSY;
    ask(6, FIRST_HOLDING, 1);
    check_exception(6, MODBUS_BUSY);
}

static void write_many_echoes_address_and_count(void)
{
    static const uint8_t echo[] = {UNIT, 16, 0, FIRST_HOLDING + 1, 0, 3};

    write_many(UNIT, FIRST_HOLDING + 1, 3, 6, 3);
    TEST_ASSERT_EQUAL_UINT16(8, reply_bytes);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(echo, frame.bytes, sizeof echo);
    TEST_ASSERT_EQUAL_HEX16(0x5500, holdings[1]);
    TEST_ASSERT_EQUAL_HEX16(0x5502, holdings[3]);
    TEST_ASSERT_EQUAL_HEX16(0, holdings[4]);
}

static void write_as_many_as_fit(void)
{
    write_many(UNIT, FIRST_HOLDING, 123, 246, 123);
    TEST_ASSERT_EQUAL_UINT16(8, reply_bytes);
    TEST_ASSERT_EQUAL_HEX16(0x5500 + 122, holdings[122]);
}

static void write_many_exceptions(void)
{
    write_many(UNIT, FIRST_HOLDING, 0, 0, 0);
    check_exception(16, MODBUS_ILLEGAL_VALUE);
    write_many(UNIT, FIRST_HOLDING, 124, 248, 123);
    check_exception(16, MODBUS_ILLEGAL_VALUE);
    write_many(UNIT, FIRST_HOLDING, 2, 3, 2);
    check_exception(16, MODBUS_ILLEGAL_VALUE);
    write_many(UNIT, FIRST_HOLDING, 2, 4, 1);
    check_exception(16, MODBUS_ILLEGAL_VALUE);
    write_many(UNIT, FIRST_HOLDING, 2, 4, 3);
    check_exception(16, MODBUS_ILLEGAL_VALUE);
    request(UNIT, 16, FIRST_HOLDING, 1);
    serve(6);
    check_exception(16, MODBUS_ILLEGAL_VALUE);
    write_many(UNIT, 0, 2, 4, 2);
    check_exception(16, MODBUS_ILLEGAL_ADDRESS);
    write_many(UNIT, 0, 2, 3, 2);
    check_exception(16, MODBUS_ILLEGAL_VALUE);
    TEST_ASSERT_EQUAL_UINT16(0, writes);
    answer = MODBUS_DEVICE_FAILURE;
    write_many(UNIT, FIRST_HOLDING, 2, 4, 2);
    check_exception(16, MODBUS_DEVICE_FAILURE);
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

// The bytes behind a broadcast may already be the next frame.
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
    RUN_TEST(read_inputs);
    RUN_TEST(read_as_much_as_fits);
    RUN_TEST(read_records);
    RUN_TEST(read_holdings);
    RUN_TEST(read_exceptions);
    RUN_TEST(write_one_echoes);
    RUN_TEST(write_one_exceptions);
    RUN_TEST(write_many_echoes_address_and_count);
    RUN_TEST(write_as_many_as_fit);
    RUN_TEST(write_many_exceptions);
    RUN_TEST(unknown_functions);
    RUN_TEST(busy_is_counted);
    RUN_TEST(broadcasts_write_without_a_reply);
    RUN_TEST(broadcasts_leave_what_follows_alone);
    RUN_TEST(other_broadcasts_are_silent);
    return UNITY_END();
}
