// SPDX-License-Identifier: MIT
#include "wire/server.h"

#include "wire/bytes.h" // get_word, put_word

#define READ_MAX_WORDS  125u
#define WRITE_MAX_WORDS 123u

#define FUNCTION_READ_HOLDING 3u
#define FUNCTION_READ_INPUT   4u
#define FUNCTION_WRITE_ONE    6u
#define FUNCTION_WRITE_MANY   16u
#define FUNCTION_IDENTIFY     17u

// Bytes of address and PDU in a request, without the checksum.
static uint16_t request_bytes(const struct frame *frame)
{
    return (uint16_t)(frame->length - 2u);
}

static enum modbus_exception read_words(struct frame *frame,
                                        uint16_t *reply_bytes,
                                        bool input)
{
    uint8_t *bytes = frame->bytes;

    if (request_bytes(frame) != 6) {
        return MODBUS_ILLEGAL_VALUE;
    }
    uint16_t address = get_word(&bytes[2]);
    uint16_t count = get_word(&bytes[4]);

    if (count == 0 || count > READ_MAX_WORDS) {
        return MODBUS_ILLEGAL_VALUE;
    }
    if (!(input ? data_input_mapped(address, count)
                : data_holding_mapped(address, count))) {
        return MODBUS_ILLEGAL_ADDRESS;
    }
    bytes[2] = (uint8_t)(2u * count);
    for (uint16_t i = 0; i < count; i++) {
        uint16_t at = (uint16_t)(address + i);
        put_word(&bytes[3u + 2u * i], input ? data_input(at) : data_holding(at));
    }
    *reply_bytes = (uint16_t)(3u + 2u * count);
    return MODBUS_OK;
}

static enum modbus_exception write_one(struct frame *frame, uint16_t *reply_bytes)
{
    uint8_t *bytes = frame->bytes;

    if (request_bytes(frame) != 6) {
        return MODBUS_ILLEGAL_VALUE;
    }
    uint16_t address = get_word(&bytes[2]);

    if (!data_holding_mapped(address, 1)) {
        return MODBUS_ILLEGAL_ADDRESS;
    }
    *reply_bytes = 6;
    return data_write(address, 1, &bytes[4]);
}

static enum modbus_exception write_many(struct frame *frame, uint16_t *reply_bytes)
{
    uint8_t *bytes = frame->bytes;

    if (request_bytes(frame) < 7) {
        return MODBUS_ILLEGAL_VALUE;
    }
    uint16_t address = get_word(&bytes[2]);
    uint16_t count = get_word(&bytes[4]);

    if (count == 0 || count > WRITE_MAX_WORDS || bytes[6] != 2u * count ||
        request_bytes(frame) != 7u + 2u * count) {
        return MODBUS_ILLEGAL_VALUE;
    }
    if (!data_holding_mapped(address, count)) {
        return MODBUS_ILLEGAL_ADDRESS;
    }
    *reply_bytes = 6;
    return data_write(address, count, &bytes[7]);
}

static enum modbus_exception identify(struct frame *frame, uint16_t *reply_bytes)
{
    uint8_t *bytes = frame->bytes;

    if (request_bytes(frame) != 2) {
        return MODBUS_ILLEGAL_VALUE;
    }
    uint8_t text = data_identity(&bytes[5], 64);
    bytes[2] = (uint8_t)(text + 2u);
    bytes[3] = data_server_id();
    bytes[4] = data_running() ? 0xFF : 0x00;
    *reply_bytes = (uint16_t)(5u + text);
    return MODBUS_OK;
}

static enum modbus_exception serve_function(struct frame *frame, uint16_t *reply_bytes)
{
    bool broadcast = frame->bytes[0] == 0;

    switch (frame->bytes[1]) {
    case FUNCTION_READ_HOLDING:
    case FUNCTION_READ_INPUT:
        return broadcast ? MODBUS_OK
                         : read_words(frame,
                                      reply_bytes,
                                      frame->bytes[1] == FUNCTION_READ_INPUT);
    case FUNCTION_WRITE_ONE:
        return write_one(frame, reply_bytes);
    case FUNCTION_WRITE_MANY:
        return write_many(frame, reply_bytes);
    case FUNCTION_IDENTIFY:
        return broadcast ? MODBUS_OK : identify(frame, reply_bytes);
    default:
        return MODBUS_ILLEGAL_FUNCTION;
    }
}

uint16_t server_serve(struct frame *frame, struct server_counters *counters)
{
    uint16_t reply_bytes = 0;
    bool broadcast = frame->bytes[0] == 0;
    enum modbus_exception exception = serve_function(frame, &reply_bytes);

    counters->frames_ok++;
    if (broadcast) {
        return 0;
    }
    if (exception != MODBUS_OK) {
        counters->exceptions++;
        frame->bytes[1] |= 0x80u;
        frame->bytes[2] = (uint8_t)exception;
        reply_bytes = 3;
    }
    return reply_bytes;
}
