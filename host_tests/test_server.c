// SPDX-License-Identifier: MIT
// The Modbus server over a few registers: replies, and exceptions in the standard's
// order.
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#include "unity.h"
#include "wire/bytes.h"
#include "wire/crc16.h"
#include "wire/server.h"

#define UNIT          1u
#define INPUTS        126u
#define HOLDINGS      124u
#define FIRST_HOLDING 0x10u

static uint16_t holdings[HOLDINGS];
static uint16_t writes; // calls of data_write
static enum modbus_exception answer;
static bool running;
static struct frame frame;
static struct server_counters counters;
static uint16_t reply_bytes;

bool data_input_mapped(uint16_t address, uint16_t count)
{
    return (uint32_t)address + count <= INPUTS;
}

uint16_t data_input(uint16_t address)
{
    return (uint16_t)(0xA000u + address);
}

bool data_holding_mapped(uint16_t address, uint16_t count)
{
    return address >= FIRST_HOLDING &&
           (uint32_t)address + count <= FIRST_HOLDING + HOLDINGS;
}

uint16_t data_holding(uint16_t address)
{
    return holdings[address - FIRST_HOLDING];
}

enum modbus_exception data_write(uint16_t address, uint16_t count, const uint8_t *words)
{
    writes++;
    for (uint16_t i = 0; answer == MODBUS_OK && i < count; i++) {
        holdings[address - FIRST_HOLDING + i] = get_word(&words[2u * i]);
    }
    return answer;
}

uint8_t data_identity(uint8_t *text, uint8_t room)
{
    static const uint8_t identity[] = {'t', 'e', 's', 't'};

    TEST_ASSERT_TRUE(room >= sizeof identity);
    memcpy(text, identity, sizeof identity);
    return 4;
}

bool data_running(void)
{
    return running;
}

uint8_t data_server_id(void)
{
    return 42;
}

void setUp(void)
{
    memset(holdings, 0, sizeof holdings);
    counters = (struct server_counters){0, 0, 0};
    writes = 0;
    answer = MODBUS_OK;
    running = false;
}

void tearDown(void)
{
}

// The request's bytes are in the frame already; serve them.
static void serve(uint16_t length)
{
    uint16_t ok = counters.frames_ok;

    frame.length = frame_seal(&frame, length);
    reply_bytes = server_serve(&frame, &counters);
    reply_bytes = reply_bytes == 0 ? 0 : frame_seal(&frame, reply_bytes);
    TEST_ASSERT_EQUAL_UINT16(ok + 1u, counters.frames_ok);
    if (reply_bytes != 0) {
        TEST_ASSERT_EQUAL_HEX16(0, crc16(frame.bytes, reply_bytes));
    }
}

static void request(uint8_t unit, uint8_t function, uint16_t first, uint16_t second)
{
    frame.bytes[0] = unit;
    frame.bytes[1] = function;
    put_word(&frame.bytes[2], first);
    put_word(&frame.bytes[4], second);
}

static void ask(uint8_t function, uint16_t first, uint16_t second)
{
    request(UNIT, function, first, second);
    serve(6);
}

// A write of `count` words 0x5500, 0x5501, ... with a byte count and length of one's own.
static void write_many(uint8_t unit,
                       uint16_t address,
                       uint16_t count,
                       uint8_t byte_count,
                       uint16_t words_sent)
{
    request(unit, 16, address, count);
    frame.bytes[6] = byte_count;
    for (uint16_t i = 0; i < words_sent; i++) {
        put_word(&frame.bytes[7u + 2u * i], (uint16_t)(0x5500u + i));
    }
    serve((uint16_t)(7u + 2u * words_sent));
}

static void check_exception(uint8_t function, enum modbus_exception exception)
{
    TEST_ASSERT_EQUAL_UINT16(5, reply_bytes);
    TEST_ASSERT_EQUAL_HEX8(UNIT, frame.bytes[0]);
    TEST_ASSERT_EQUAL_HEX8(function | 0x80u, frame.bytes[1]);
    TEST_ASSERT_EQUAL_HEX8(exception, frame.bytes[2]);
    TEST_ASSERT_EQUAL_UINT16(1, counters.exceptions);
    counters.exceptions = 0;
}

static void check_words(uint16_t count, uint16_t first)
{
    TEST_ASSERT_EQUAL_UINT16(5u + 2u * count, reply_bytes);
    TEST_ASSERT_EQUAL_UINT8(2u * count, frame.bytes[2]);
    for (uint16_t i = 0; i < count; i++) {
        TEST_ASSERT_EQUAL_HEX16(first + i, get_word(&frame.bytes[3u + 2u * i]));
    }
}

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
    // Both wrong: the quantity is looked at first.
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

static void identify(void)
{
    static const uint8_t reply[] = {UNIT, 17, 6, 42, 0x00, 't', 'e', 's', 't'};

    request(UNIT, 17, 0, 0);
    serve(2);
    TEST_ASSERT_EQUAL_UINT16(sizeof reply + 2u, reply_bytes);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(reply, frame.bytes, sizeof reply);
    running = true;
    request(UNIT, 17, 0, 0);
    serve(2);
    TEST_ASSERT_EQUAL_HEX8(0xFF, frame.bytes[4]);
    request(UNIT, 17, 0, 0);
    serve(3);
    check_exception(17, MODBUS_ILLEGAL_VALUE);
}

static void unknown_functions(void)
{
    static const uint8_t functions[] = {0, 1, 2, 5, 15, 22, 23, 43, 0x7F};

    for (uint8_t i = 0; i < (uint8_t)sizeof functions; i++) {
        ask(functions[i], 0xFFFF, 0);
        check_exception(functions[i], MODBUS_ILLEGAL_FUNCTION);
    }
}

static void broadcasts_write_without_a_reply(void)
{
    request(0, 6, FIRST_HOLDING, 0x77);
    serve(6);
    TEST_ASSERT_EQUAL_UINT16(0, reply_bytes);
    TEST_ASSERT_EQUAL_HEX16(0x77, holdings[0]);
    write_many(0, FIRST_HOLDING + 1, 2, 4, 2);
    TEST_ASSERT_EQUAL_UINT16(0, reply_bytes);
    TEST_ASSERT_EQUAL_HEX16(0x5501, holdings[2]);
}

static void other_broadcasts_are_silent(void)
{
    static const uint8_t functions[] = {3, 4, 17, 99};

    for (uint8_t i = 0; i < (uint8_t)sizeof functions; i++) {
        request(0, functions[i], 0, 1);
        serve(6);
        TEST_ASSERT_EQUAL_UINT16(0, reply_bytes);
    }
    request(0, 6, 0, 1);
    serve(6);
    TEST_ASSERT_EQUAL_UINT16(0, reply_bytes);
    TEST_ASSERT_EQUAL_UINT16(0, counters.exceptions);
    TEST_ASSERT_EQUAL_UINT16(0, writes);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(read_inputs);
    RUN_TEST(read_as_much_as_fits);
    RUN_TEST(read_holdings);
    RUN_TEST(read_exceptions);
    RUN_TEST(write_one_echoes);
    RUN_TEST(write_one_exceptions);
    RUN_TEST(write_many_echoes_address_and_count);
    RUN_TEST(write_as_many_as_fit);
    RUN_TEST(write_many_exceptions);
    RUN_TEST(identify);
    RUN_TEST(unknown_functions);
    RUN_TEST(broadcasts_write_without_a_reply);
    RUN_TEST(other_broadcasts_are_silent);
    return UNITY_END();
}
