// SPDX-License-Identifier: MIT
// Function 20: registers as records of files.
#include <stdint.h>

#include "server_bench.h"

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

// The bytes behind a frame may look like part of an older request.
static void part_of_a_request_is_refused(void)
{
    put_file(0, 1, 0, 1);
    put_file(1, 1, 0, 1);
    frame.bytes[0] = UNIT;
    frame.bytes[1] = 20;
    frame.bytes[2] = 8;
    serve(3 + 8);
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

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(files_are_registers);
    RUN_TEST(many_files_at_once);
    RUN_TEST(one_file_as_long_as_fits);
    RUN_TEST(part_of_a_request_is_refused);
    RUN_TEST(files_exceptions);
    return UNITY_END();
}
