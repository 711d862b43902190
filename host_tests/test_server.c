// SPDX-License-Identifier: MIT
// The Modbus server over a few registers: replies, and exceptions in the standard's
// order.
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#include "unity.h"
#include "wire/bytes.h"
#include "wire/crc16.h"
#include "wire/register_map.h"
#include "wire/server.h"

#define UNIT          1u
#define INPUTS        126u
#define HOLDINGS      124u
#define FIRST_HOLDING 0x10u
#define COILS         14u
#define DISCRETE      32u
#define RECORDS       0x0100u // first input registers of the files 1 and 2
#define EVENTS        0x0300u

static uint16_t holdings[HOLDINGS];
static uint16_t coils;
static uint16_t writes; // calls of data_write and data_write_coils
static enum modbus_exception answer;
static bool running;
static struct frame frame;
static struct server_counters counters;
static uint16_t reply_bytes;

bool data_input_mapped(uint16_t address, uint16_t count)
{
    return (uint32_t)address + count <= INPUTS ||
           (address >= RECORDS && (uint32_t)address + count <= RECORDS + 200u) ||
           (address >= EVENTS && (uint32_t)address + count <= EVENTS + 9u);
}

uint16_t data_input(uint16_t address)
{
    return (uint16_t)(0xA000u + address);
}

bool data_bits_mapped(uint16_t address, uint16_t count, uint8_t which)
{
    return (uint32_t)address + count <= (which == SERVER_COILS ? COILS : DISCRETE);
}

// Every third discrete input is on.
bool data_bit(uint16_t address, uint8_t which)
{
    return which == SERVER_COILS ? (coils >> address & 1u) != 0 : address % 3u == 0;
}

enum modbus_exception data_write_coils(uint16_t address,
                                       uint16_t count,
                                       const uint8_t *bits)
{
    writes++;
    for (uint16_t i = 0; answer == MODBUS_OK && i < count; i++) {
        uint16_t place = (uint16_t)(1u << (address + i));
        bool on = ((uint8_t)(bits[i / 8u] >> (i % 8u)) & 1u) != 0;
        coils = (uint16_t)(on ? coils | place : coils & ~place);
    }
    return answer;
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
    static const uint8_t identity[] = {'m', 'e', ' ', 'b', '1', ' ', '0', '.', '7'};

    TEST_ASSERT_TRUE(room >= sizeof identity);
    memcpy(text, identity, sizeof identity);
    return sizeof identity;
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
    counters = (struct server_counters){0};
    coils = 0;
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
    frame.length = frame_seal(&frame, length);
    reply_bytes = server_serve(&frame, &counters);
    reply_bytes = reply_bytes == 0 ? 0 : frame_seal(&frame, reply_bytes);
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

// A request of one's own, address included.
static void send(const uint8_t *bytes, uint8_t length)
{
    memcpy(frame.bytes, bytes, length);
    serve(length);
}

static void check_reply(const uint8_t *bytes, uint8_t length)
{
    TEST_ASSERT_EQUAL_UINT16(length + 2u, reply_bytes);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(bytes, frame.bytes, length);
    TEST_ASSERT_EQUAL_UINT16(0, counters.exceptions);
}

#define SEND(...)                                                                        \
    send((const uint8_t[]){__VA_ARGS__}, (uint8_t)sizeof (const uint8_t[]){__VA_ARGS__})
#define CHECK_REPLY(...)                                                                 \
    check_reply((const uint8_t[]){__VA_ARGS__},                                          \
                (uint8_t)sizeof (const uint8_t[]){__VA_ARGS__})

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
    SEND(UNIT, 17);
    CHECK_REPLY(UNIT, 17, 11, 42, 0x00, 'm', 'e', ' ', 'b', '1', ' ', '0', '.', '7');
    running = true;
    SEND(UNIT, 17);
    TEST_ASSERT_EQUAL_HEX8(0xFF, frame.bytes[4]);
    SEND(UNIT, 17, 0);
    check_exception(17, MODBUS_ILLEGAL_VALUE);
}

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

static void listen_only_does_nothing_until_a_restart(void)
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
    RUN_TEST(loopback_repeats_the_request);
    RUN_TEST(diagnostic_register_is_the_status);
    RUN_TEST(counters_are_told);
    RUN_TEST(counters_are_cleared);
    RUN_TEST(diagnosis_exceptions);
    RUN_TEST(restart_answers_and_clears);
    RUN_TEST(listen_only_does_nothing_until_a_restart);
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
