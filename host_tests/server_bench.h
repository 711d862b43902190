// SPDX-License-Identifier: MIT
// What suites of the Modbus server share: data behind it, requests to it, looks at its replies.
#pragma once

#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#include "unity.h"
#include "wire/bytes.h"
#include "wire/crc16.h"
#include "wire/register_map.h"
#include "wire/server.h"
#include "wire/server_data.h"

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

// Every seventh register and the two behind it are had together.
uint8_t data_inputs(uint16_t address, uint8_t count, uint8_t *to)
{
    if (address % 7u != 0 || count < 3u) {
        return 0;
    }
    for (uint8_t i = 0; i < 3u; i++, to += 2) {
        put_word(to, data_input((uint16_t)(address + i)));
    }
    return 3;
}

bool data_bits_mapped(uint16_t address, uint16_t count, uint8_t which)
{
    return (uint32_t)address + count <= (which == SERVER_COILS ? COILS : DISCRETE);
}

// Every third discrete input is on.
bool data_bit(uint16_t address, uint8_t which)
{
    return which == SERVER_COILS ? ((uint16_t)(coils >> address) & 1u) != 0
                                 : address % 3u == 0;
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

enum modbus_exception data_write(uint16_t address, uint16_t count, uint8_t *words)
{
    writes++;
    for (uint16_t i = 0; answer == MODBUS_OK && i < count; i++) {
        holdings[address - FIRST_HOLDING + i] = get_word(&words[2u * i]);
        put_word(&words[2u * i], 0xDEADu); // any value, as the contract says
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
static inline void serve(uint16_t length)
{
    frame.length = frame_seal(&frame, length);
    reply_bytes = server_serve(&frame, &counters);
    reply_bytes = reply_bytes == 0 ? 0 : frame_seal(&frame, reply_bytes);
    if (reply_bytes != 0) {
        TEST_ASSERT_EQUAL_HEX16(0, crc16(frame.bytes, reply_bytes));
    }
}

static inline void request(uint8_t unit,
                           uint8_t function,
                           uint16_t first,
                           uint16_t second)
{
    frame.bytes[0] = unit;
    frame.bytes[1] = function;
    put_word(&frame.bytes[2], first);
    put_word(&frame.bytes[4], second);
}

static inline void ask(uint8_t function, uint16_t first, uint16_t second)
{
    request(UNIT, function, first, second);
    serve(6);
}

// A write of `count` words 0x5500, 0x5501, ... with a byte count and length of one's own.
static inline void write_many(uint8_t unit,
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

static inline void check_exception(uint8_t function, enum modbus_exception exception)
{
    TEST_ASSERT_EQUAL_UINT16(5, reply_bytes);
    TEST_ASSERT_EQUAL_HEX8(UNIT, frame.bytes[0]);
    TEST_ASSERT_EQUAL_HEX8(function | 0x80u, frame.bytes[1]);
    TEST_ASSERT_EQUAL_HEX8(exception, frame.bytes[2]);
    TEST_ASSERT_EQUAL_UINT16(1, counters.exceptions);
    counters.exceptions = 0;
}

// A request of one's own, address included.
static inline void send(const uint8_t *bytes, uint8_t length)
{
    memcpy(frame.bytes, bytes, length);
    serve(length);
}

static inline void check_reply(const uint8_t *bytes, uint8_t length)
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

static inline void check_words(uint16_t count, uint16_t first)
{
    TEST_ASSERT_EQUAL_UINT16(5u + 2u * count, reply_bytes);
    TEST_ASSERT_EQUAL_UINT8(2u * count, frame.bytes[2]);
    for (uint16_t i = 0; i < count; i++) {
        TEST_ASSERT_EQUAL_HEX16(first + i, get_word(&frame.bytes[3u + 2u * i]));
    }
}

static inline void check_silent(void)
{
    TEST_ASSERT_EQUAL_UINT16(0, reply_bytes);
}
