// SPDX-License-Identifier: MIT
// The Modbus server's coils and discrete inputs, and registers changed in part or read as well.
#include <stdint.h>

#include "server_bench.h"

static void read_bits(void)
{
    coils = 0x2A05;
    SEND(UNIT, 1, 0, 0, 0, 14);
    CHECK_REPLY(UNIT, 1, 2, 0x05, 0x2A);
    SEND(UNIT, 1, 0, 2, 0, 8);
    CHECK_REPLY(UNIT, 1, 1, 0x81);
    SEND(UNIT, 1, 0, 13, 0, 1);
    CHECK_REPLY(UNIT, 1, 1, 0x01);
    SEND(UNIT, 2, 0, 0, 0, 9);
    CHECK_REPLY(UNIT, 2, 2, 0x49, 0x00);
    SEND(UNIT, 2, 0, 30, 0, 2);
    CHECK_REPLY(UNIT, 2, 1, 0x01);
    SEND(UNIT, 2, 0, 0, 0, 32);
    CHECK_REPLY(UNIT, 2, 4, 0x49, 0x92, 0x24, 0x49);
}

static void read_bits_exceptions(void)
{
    for (uint8_t function = 1; function <= 2; function++) {
        ask(function, 0, 0);
        check_exception(function, MODBUS_ILLEGAL_VALUE);
        ask(function, 0, 2001);
        check_exception(function, MODBUS_ILLEGAL_VALUE);
        ask(function, 0xFFFF, 2001);
        check_exception(function, MODBUS_ILLEGAL_VALUE);
        ask(function, 0, 2000);
        check_exception(function, MODBUS_ILLEGAL_ADDRESS);
        ask(function, 0xFFFF, 2);
        check_exception(function, MODBUS_ILLEGAL_ADDRESS);
        SEND(UNIT, function, 0, 0, 0, 1, 0);
        check_exception(function, MODBUS_ILLEGAL_VALUE);
    }
    ask(1, 13, 2);
    check_exception(1, MODBUS_ILLEGAL_ADDRESS);
}

static void write_coil_echoes(void)
{
    ask(5, 9, 0xFF00);
    CHECK_REPLY(UNIT, 5, 0, 9, 0xFF, 0);
    TEST_ASSERT_EQUAL_HEX16(0x0200, coils);
    coils = 0xFFFF;
    ask(5, 9, 0);
    CHECK_REPLY(UNIT, 5, 0, 9, 0, 0);
    TEST_ASSERT_EQUAL_HEX16(0xFDFF, coils);
}

static void write_coil_exceptions(void)
{
    static const uint16_t values[] = {1, 0xFF01, 0xFE00, 0x0100, 0x00FF, 0xFFFF};

    for (uint8_t i = 0; i < (uint8_t)(sizeof values / sizeof values[0]); i++) {
        ask(5, 99, values[i]); // the value is looked at before the address
        check_exception(5, MODBUS_ILLEGAL_VALUE);
    }
    ask(5, 14, 0xFF00);
    check_exception(5, MODBUS_ILLEGAL_ADDRESS);
    TEST_ASSERT_EQUAL_UINT16(0, writes);
    answer = MODBUS_DEVICE_FAILURE;
    ask(5, 0, 0xFF00);
    check_exception(5, MODBUS_DEVICE_FAILURE);
}

static void write_coils_echoes_address_and_count(void)
{
    coils = 0x3FFF;
    SEND(UNIT, 15, 0, 3, 0, 10, 2, 0xA5, 0xFE);
    CHECK_REPLY(UNIT, 15, 0, 3, 0, 10);
    TEST_ASSERT_EQUAL_HEX16(0x3FFF & ((0x2A5 << 3) | 0x2007), coils);
    SEND(UNIT, 15, 0, 0, 0, 8, 1, 0x0F);
    CHECK_REPLY(UNIT, 15, 0, 0, 0, 8);
    TEST_ASSERT_EQUAL_HEX8(0x0F, coils & 0xFF);
}

static void write_coils_exceptions(void)
{
    SEND(UNIT, 15, 0, 0, 0, 0, 0);
    check_exception(15, MODBUS_ILLEGAL_VALUE);
    SEND(UNIT, 15, 0, 0, 0, 8, 2, 0, 0);
    check_exception(15, MODBUS_ILLEGAL_VALUE);
    SEND(UNIT, 15, 0, 0, 0, 9, 1, 0);
    check_exception(15, MODBUS_ILLEGAL_VALUE);
    SEND(UNIT, 15, 0, 99, 8, 8, 1, 0); // 2056 by one byte
    check_exception(15, MODBUS_ILLEGAL_VALUE);
    SEND(UNIT, 15, 0, 0, 0, 8, 1, 0, 0);
    check_exception(15, MODBUS_ILLEGAL_VALUE);
    SEND(UNIT, 15, 0, 13, 0, 2, 1, 0);
    check_exception(15, MODBUS_ILLEGAL_ADDRESS);
    TEST_ASSERT_EQUAL_UINT16(0, writes);
    answer = MODBUS_BUSY;
    SEND(UNIT, 15, 0, 0, 0, 8, 1, 0);
    check_exception(15, MODBUS_BUSY);
}

// 1968 are as many as may be asked for: more is a wrong number, so many are a wrong place.
static void write_coils_up_to_the_standards_number(void)
{
    request(UNIT, 15, 0, 1968);
    frame.bytes[6] = 246;
    serve(7 + 246);
    check_exception(15, MODBUS_ILLEGAL_ADDRESS);
    request(UNIT, 15, 0, 1969);
    frame.bytes[6] = 247;
    serve(7 + 247);
    check_exception(15, MODBUS_ILLEGAL_VALUE);
}

static void mask_changes_some_bits(void)
{
    holdings[3] = 0x1234;
    SEND(UNIT, 22, 0, FIRST_HOLDING + 3, 0xF0, 0x0F, 0x0A, 0xA5);
    CHECK_REPLY(UNIT, 22, 0, FIRST_HOLDING + 3, 0xF0, 0x0F, 0x0A, 0xA5);
    TEST_ASSERT_EQUAL_HEX16((0x1234 & 0xF00F) | (0x0AA5 & 0x0FF0), holdings[3]);
}

static void mask_exceptions(void)
{
    SEND(UNIT, 22, 0, 0, 0, 0, 0, 0);
    check_exception(22, MODBUS_ILLEGAL_ADDRESS);
    SEND(UNIT, 22, 0, FIRST_HOLDING, 0, 0);
    check_exception(22, MODBUS_ILLEGAL_VALUE);
    TEST_ASSERT_EQUAL_UINT16(0, writes);
    answer = MODBUS_ILLEGAL_VALUE;
    SEND(UNIT, 22, 0, FIRST_HOLDING, 0, 0, 0, 0);
    check_exception(22, MODBUS_ILLEGAL_VALUE);
}

static void write_comes_before_read(void)
{
    holdings[5] = 0x5555;
    SEND(UNIT, 23, 0, FIRST_HOLDING + 4, 0, 2, 0, FIRST_HOLDING + 4, 0, 1, 2, 0x12, 0x34);
    CHECK_REPLY(UNIT, 23, 4, 0x12, 0x34, 0x55, 0x55);
}

static void write_and_read_exceptions(void)
{
    // Numbers: none to read, too many, none to write, other than the bytes say.
    SEND(UNIT, 23, 0, 0, 0, 0, 0, 0, 0, 1, 2, 0, 0);
    check_exception(23, MODBUS_ILLEGAL_VALUE);
    SEND(UNIT, 23, 0, 0, 0, 126, 0, 0, 0, 1, 2, 0, 0);
    check_exception(23, MODBUS_ILLEGAL_VALUE);
    SEND(UNIT, 23, 0, 0, 0, 1, 0, 0, 0, 0, 0);
    check_exception(23, MODBUS_ILLEGAL_VALUE);
    SEND(UNIT, 23, 0, 0, 0, 1, 0, 0, 0, 2, 2, 0, 0);
    check_exception(23, MODBUS_ILLEGAL_VALUE);
    SEND(UNIT, 23, 0, 0, 0, 1, 0, 0, 1, 1, 2, 0, 0);
    check_exception(23, MODBUS_ILLEGAL_VALUE);
    SEND(UNIT, 23, 0, 0, 0, 1, 0, 0, 0, 1, 2, 0);
    check_exception(23, MODBUS_ILLEGAL_VALUE);
    // Addresses: of what is read, of what is written.
    SEND(UNIT, 23, 0, 0, 0, 1, 0, FIRST_HOLDING, 0, 1, 2, 0, 0);
    check_exception(23, MODBUS_ILLEGAL_ADDRESS);
    SEND(UNIT, 23, 0, FIRST_HOLDING, 0, 1, 0, 0, 0, 1, 2, 0, 0);
    check_exception(23, MODBUS_ILLEGAL_ADDRESS);
    TEST_ASSERT_EQUAL_UINT16(0, writes);
    answer = MODBUS_BUSY;
    SEND(UNIT, 23, 0, FIRST_HOLDING, 0, 1, 0, FIRST_HOLDING, 0, 1, 2, 0, 0);
    check_exception(23, MODBUS_BUSY);
}

static void write_and_read_as_much_as_fits(void)
{
    request(UNIT, 23, FIRST_HOLDING, 124);
    put_word(&frame.bytes[6], FIRST_HOLDING + 3);
    put_word(&frame.bytes[8], 121);
    frame.bytes[10] = 242;
    for (uint16_t i = 0; i < 121; i++) {
        put_word(&frame.bytes[11 + 2 * i], (uint16_t)(3 + i));
    }
    holdings[1] = 1;
    holdings[2] = 2;
    serve(11 + 242);
    check_words(124, 0);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(read_bits);
    RUN_TEST(read_bits_exceptions);
    RUN_TEST(write_coil_echoes);
    RUN_TEST(write_coil_exceptions);
    RUN_TEST(write_coils_echoes_address_and_count);
    RUN_TEST(write_coils_exceptions);
    RUN_TEST(write_coils_up_to_the_standards_number);
    RUN_TEST(mask_changes_some_bits);
    RUN_TEST(mask_exceptions);
    RUN_TEST(write_comes_before_read);
    RUN_TEST(write_and_read_exceptions);
    RUN_TEST(write_and_read_as_much_as_fits);
    return UNITY_END();
}
