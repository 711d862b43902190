// SPDX-License-Identifier: MIT
#include "wire/server.h"

#include "wire/bytes.h"        // get_word, put_word
#include "wire/files.h"        // files_read
#include "wire/register_map.h" // REG_INPUT_status

#define READ_MAX_BITS   2000u
#define READ_MAX_WORDS  125u
#define WRITE_MAX_BITS  1968u
#define WRITE_MAX_WORDS 123u
#define BOTH_MAX_WORDS  121u // written by function 23

enum function {
    READ_COILS = 1,
    READ_DISCRETE = 2,
    READ_HOLDING = 3,
    READ_INPUT = 4,
    WRITE_COIL = 5,
    WRITE_WORD = 6,
    DIAGNOSE = 8,
    WRITE_COILS = 15,
    WRITE_WORDS = 16,
    IDENTIFY = 17,
    READ_FILES = 20,
    MASK_WORD = 22,
    WRITE_AND_READ = 23,
    READ_DEVICE = 43,
};

// Sub-functions of DIAGNOSE.
enum diagnosis {
    LOOPBACK = 0,
    RESTART = 1,
    DIAGNOSTIC_REGISTER = 2,
    LISTEN_ONLY = 4,
    CLEAR_COUNTERS = 10,
    FIRST_COUNTER = 11,
    LAST_COUNTER = 18,
};

#define REPLY_TO_WRITE 6u // address, function, first, number
#define ON             0xFFu

#define DEVICE_MEI      14u // the kind of function 43 that is served
#define DEVICE_CODES    4u  // basic, regular, extended, individual
#define DEVICE_OBJECTS  3u
#define DEVICE_CONFORMS 0x81u // basic; by stream and individually
#define IDENTITY_MAX    64u
#define IDENTITY_AT     128u // in the frame, beside the reply that is made of it

// Quantity, then address. `read`: the function that reads such data.
static enum modbus_exception check(uint8_t read,
                                   uint16_t address,
                                   uint16_t count,
                                   uint16_t max)
{
    bool mapped = false;

    if ((uint16_t)(count - 1u) >= max) {
        return MODBUS_ILLEGAL_VALUE;
    }
    if (read == READ_INPUT) {
        mapped = data_input_mapped(address, count);
    } else if (read == READ_HOLDING) {
        mapped = data_holding_mapped(address, count);
    } else {
        mapped = data_bits_mapped(read == READ_COILS, address, count);
    }
    return mapped ? MODBUS_OK : MODBUS_ILLEGAL_ADDRESS;
}

static void reply_words(struct frame *frame, bool input, uint16_t address, uint8_t count)
{
    uint8_t *to = &frame->bytes[2];

    *to++ = (uint8_t)(2u * count);
    for (; count != 0; count--) {
        put_word(to, input ? data_input(address) : data_holding(address));
        to += 2;
        address++;
    }
    frame->length = (uint16_t)(to - frame->bytes);
}

static void reply_bits(struct frame *frame, bool coils, uint16_t address, uint16_t count)
{
    uint8_t *to = &frame->bytes[2];
    uint8_t bit = 0;

    *to = (uint8_t)((count + 7u) / 8u);
    for (; count != 0; count--) {
        if (bit == 0) {
            bit = 1;
            *++to = 0;
        }
        if (data_bit(coils, address)) {
            *to |= bit;
        }
        bit = (uint8_t)(bit << 1);
        address++;
    }
    frame->length = (uint16_t)(to + 1 - frame->bytes);
}

static enum modbus_exception read(struct frame *frame, uint16_t address, uint16_t count)
{
    uint8_t function = frame->bytes[1];
    bool words = function >= READ_HOLDING;
    enum modbus_exception exception =
        check(function, address, count, words ? READ_MAX_WORDS : READ_MAX_BITS);

    if (exception != MODBUS_OK) {
        return exception;
    }
    if (words) {
        reply_words(frame, function == READ_INPUT, address, (uint8_t)count);
    } else {
        reply_bits(frame, function == READ_COILS, address, count);
    }
    return MODBUS_OK;
}

static enum modbus_exception write_words(uint16_t address,
                                         uint16_t count,
                                         uint16_t max,
                                         const uint8_t *words)
{
    enum modbus_exception exception = check(READ_HOLDING, address, count, max);

    return exception != MODBUS_OK ? exception : data_write(address, count, words);
}

static enum modbus_exception write_coils(uint16_t address,
                                         uint16_t count,
                                         const uint8_t *bits)
{
    enum modbus_exception exception =
        check(READ_COILS, address, count, WRITE_MAX_BITS);

    return exception != MODBUS_OK ? exception : data_write_coils(address, count, bits);
}

static enum modbus_exception write_many(struct frame *frame,
                                        uint16_t address,
                                        uint16_t count)
{
    uint8_t *bytes = frame->bytes;
    bool words = bytes[1] == WRITE_WORDS;

    frame->length = REPLY_TO_WRITE;
    if (bytes[6] != (uint8_t)(words ? 2u * count : (count + 7u) / 8u)) {
        return MODBUS_ILLEGAL_VALUE;
    }
    return words ? write_words(address, count, WRITE_MAX_WORDS, &bytes[7])
                 : write_coils(address, count, &bytes[7]);
}

static enum modbus_exception mask_word(struct frame *frame, uint16_t address)
{
    uint8_t *bytes = frame->bytes;
    uint16_t keep = get_word(&bytes[4]);
    uint8_t word[2];

    put_word(word,
             (uint16_t)((data_holding(address) & keep) | (get_word(&bytes[6]) & ~keep)));
    return write_words(address, 1, 1, word);
}

static enum modbus_exception write_and_read(struct frame *frame,
                                            uint16_t address,
                                            uint16_t count)
{
    uint8_t *bytes = frame->bytes;
    uint16_t write_count = get_word(&bytes[8]);

    if ((uint16_t)(write_count - 1u) >= BOTH_MAX_WORDS ||
        bytes[10] != (uint8_t)(2u * write_count)) {
        return MODBUS_ILLEGAL_VALUE;
    }
    enum modbus_exception exception = check(READ_HOLDING, address, count, READ_MAX_WORDS);

    if (exception == MODBUS_OK) {
        exception =
            write_words(get_word(&bytes[6]), write_count, BOTH_MAX_WORDS, &bytes[11]);
    }
    if (exception == MODBUS_OK) {
        reply_words(frame, false, address, (uint8_t)count);
    }
    return exception;
}

static bool known_diagnosis(uint16_t which)
{
    return which >= CLEAR_COUNTERS ? which <= LAST_COUNTER
                                   : which <= LISTEN_ONLY && which != 3;
}

// The request comes back, with a number in the place of its data.
static enum modbus_exception diagnose(struct frame *frame,
                                      uint16_t which,
                                      uint16_t data,
                                      struct server_counters *counters)
{
    if (!known_diagnosis(which)) {
        return MODBUS_ILLEGAL_FUNCTION;
    }
    if (which == LOOPBACK) {
        return MODBUS_OK;
    }
    if (frame->length != REPLY_TO_WRITE ||
        (data != 0 && (data != ON << 8 || which != RESTART))) {
        return MODBUS_ILLEGAL_VALUE;
    }
    if (which == LISTEN_ONLY) {
        counters->listen_only = true;
    } else if (which >= FIRST_COUNTER) {
        data = counters->all[which - FIRST_COUNTER];
    } else if (which == DIAGNOSTIC_REGISTER) {
        data = data_input(REG_INPUT_status);
    } else {
        // Two functions: who may be here in listen-only mode asks for its end.
        *counters = (struct server_counters){0};
    }
    put_word(&frame->bytes[4], data);
    return MODBUS_OK;
}

static enum modbus_exception identify(struct frame *frame)
{
    uint8_t *bytes = frame->bytes;
    uint8_t text = data_identity(&bytes[5], IDENTITY_MAX);

    bytes[2] = (uint8_t)(text + 2u);
    bytes[3] = data_server_id();
    bytes[4] = data_running() ? ON : 0x00;
    frame->length = (uint16_t)(5u + text);
    return MODBUS_OK;
}

// The words of the identity as objects, from the one asked for on, or that one.
static enum modbus_exception read_device(struct frame *frame)
{
    uint8_t *bytes = frame->bytes;
    uint8_t first = bytes[4];
    bool one = bytes[3] == DEVICE_CODES;

    if (bytes[2] != DEVICE_MEI) {
        return MODBUS_ILLEGAL_FUNCTION;
    }
    if ((uint8_t)(bytes[3] - 1u) >= DEVICE_CODES) {
        return MODBUS_ILLEGAL_VALUE;
    }
    if (first >= DEVICE_OBJECTS) {
        if (one) {
            return MODBUS_ILLEGAL_ADDRESS;
        }
        first = 0;
    }
    const uint8_t *text = &bytes[IDENTITY_AT];
    uint8_t left = data_identity(&bytes[IDENTITY_AT], IDENTITY_MAX);
    uint8_t *object = &bytes[8];

    bytes[4] = DEVICE_CONFORMS;
    bytes[5] = 0; // nothing follows
    bytes[6] = 0;
    bytes[7] = 0;
    for (uint8_t i = 0; i < DEVICE_OBJECTS; i++) {
        uint8_t length = 0;
        for (; left != 0; left--) {
            object[2u + length] = *text++;
            if (object[2u + length] == ' ') {
                left--;
                break;
            }
            length++;
        }
        if (i == first || (i > first && !one)) {
            object[0] = i;
            object[1] = length;
            object += 2u + length;
            bytes[7]++;
        }
    }
    frame->length = (uint16_t)(object - bytes);
    return MODBUS_OK;
}

static enum modbus_exception serve_function(struct frame *frame,
                                            struct server_counters *counters)
{
    uint8_t *bytes = frame->bytes;
    uint16_t first = get_word(&bytes[2]);
    uint16_t second = get_word(&bytes[4]);

    switch ((enum function)bytes[1]) {
    case WRITE_COIL:
        if (bytes[5] != 0 || (uint8_t)(bytes[4] + 1u) > 1u) {
            return MODBUS_ILLEGAL_VALUE;
        }
        return write_coils(first, 1, &bytes[4]);
    case WRITE_WORD:
        return write_words(first, 1, 1, &bytes[4]);
    case DIAGNOSE:
        return diagnose(frame, first, second, counters);
    case WRITE_COILS:
    case WRITE_WORDS:
        return write_many(frame, first, second);
    case IDENTIFY:
        return identify(frame);
    case READ_FILES:
        return SERVER_FILES ? files_read(frame) : MODBUS_ILLEGAL_FUNCTION;
    case MASK_WORD:
        return mask_word(frame, first);
    case WRITE_AND_READ:
        return write_and_read(frame, first, second);
    case READ_DEVICE:
        return read_device(frame);
    case READ_COILS:
    case READ_DISCRETE:
    case READ_HOLDING:
    case READ_INPUT:
    default:
        return read(frame, first, second);
    }
}

// Function, then the request's length; most replies are as long as what they repeat.
static enum modbus_exception serve_checked(struct frame *frame,
                                           struct server_counters *counters)
{
    uint8_t function = frame->bytes[1];
    uint8_t rule = frame_rule(function);

    if ((rule & RULE_SERVED) == 0) {
        return MODBUS_ILLEGAL_FUNCTION;
    }
    if (frame->length != frame_length_by(frame, rule) && function != DIAGNOSE) {
        return MODBUS_ILLEGAL_VALUE;
    }
    frame->length = (uint16_t)(frame->length - 2u);
    return serve_function(frame, counters);
}

static bool is_restart(const struct frame *frame)
{
    return frame->bytes[0] != 0 && frame->bytes[1] == DIAGNOSE && frame->bytes[2] == 0 &&
           frame->bytes[3] == RESTART;
}

// A request to all is executed if all may be asked for it, in listen-only mode only what ends it.
static bool to_be_executed(const struct frame *frame,
                           const struct server_counters *counters)
{
    return counters->listen_only ? is_restart(frame)
                                 : (frame_rule(frame->bytes[1]) & RULE_BROADCAST) != 0;
}

uint16_t server_serve(struct frame *frame, struct server_counters *counters)
{
    counters->frames_ok++;
    if (counters->listen_only || frame->bytes[0] == 0) {
        counters->no_replies++;
        if (to_be_executed(frame, counters)) {
            (void)serve_checked(frame, counters);
        }
        return 0;
    }
    enum modbus_exception exception = serve_checked(frame, counters);

    if (counters->listen_only) {
        counters->no_replies++;
        return 0;
    }
    if (exception != MODBUS_OK) {
        counters->exceptions++;
        if (exception == MODBUS_BUSY) {
            counters->busy_replies++;
        }
        frame->bytes[1] |= 0x80u;
        frame->bytes[2] = (uint8_t)exception;
        return 3;
    }
    return frame->length;
}
