// SPDX-License-Identifier: MIT
#include "wire/server.h"

#include "base/apart.h"        // APART
#include "base/interlude.h"    // interlude
#include "build_features.h"    // FEATURE_*
#include "wire/bytes.h"        // get_word, put_word
#include "wire/files.h"        // files_read
#include "wire/read_words.h"   // read_words
#include "wire/register_map.h" // REG_INPUT_status
#include "wire/server_data.h"  // data_*

#define READ_MAX_BITS   2000u
#define READ_MAX_WORDS  125u
#define WRITE_MAX_BYTES 246u // 1968 bits, 123 words

enum function {
    READ_COILS = SERVER_COILS,
    READ_DISCRETE = SERVER_DISCRETE,
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

// Sub-functions of function 8.
enum diagnosis {
    LOOPBACK = 0,
    RESTART = 1,
    DIAGNOSTIC_REGISTER = 2,
    INPUT_DELIMITER = 3, // belongs to the ASCII mode, which is not served
    LISTEN_ONLY = 4,
    CLEAR_COUNTERS = 10,
    FIRST_COUNTER = 11,
    LAST_COUNTER = 18,
};

#define REPLY_TO_WRITE 6u // bytes: address, function, first register, number of registers
#define ON             0xFFu

#define DEVICE_MEI      14u // the kind of function 43 that is served
#define DEVICE_CODES    4u  // basic, regular, extended, individual
#define DEVICE_OBJECTS  3u
#define DEVICE_CONFORMS 0x81u // basic; by stream and individually
#define IDENTITY_MAX    64u
#define IDENTITY_AT     128u // place of the text in the frame, behind the reply

// True for words, false for bits. Data are named after the function that reads them.
#define ARE_WORDS(data) (!FEATURE_BITS || (data) >= READ_HOLDING)

// Check the quantity, then the address. `data` is the function that reads this kind of data.
static APART enum modbus_exception check_range(uint16_t address,
                                               uint16_t count,
                                               uint8_t data)
{
    bool mapped = false;

    if ((uint16_t)(count - 1u) >= (ARE_WORDS(data) ? READ_MAX_WORDS : READ_MAX_BITS)) {
        return MODBUS_ILLEGAL_VALUE;
    }
    if (data == READ_INPUT) {
        mapped = data_input_mapped(address, count);
    } else if (!FEATURE_BITS || data == READ_HOLDING) {
        mapped = data_holding_mapped(address, count);
    } else {
        mapped = data_bits_mapped(address, count, data);
    }
    return mapped ? MODBUS_OK : MODBUS_ILLEGAL_ADDRESS;
}

// Read bits, the lowest one first. Returns the place behind them.
static inline uint8_t *read_bits(uint8_t *to,
                                 uint16_t address,
                                 uint8_t count,
                                 uint8_t data)
{
    uint8_t bit = 0;

    for (; count != 0; count--) {
        if (bit == 0) {
            interlude();
            *to++ = 0;
            bit = 1;
        }
        if (data_bit(address, data)) {
            to[-1] |= bit;
        }
        bit = (uint8_t)(bit << 1);
        address++;
    }
    return to;
}

// Read words or bits into the reply. Their number fits 8 bits, since fewer than 256 bits are mapped
// and a request has at most 125 words.
static APART enum modbus_exception read_data(struct frame *frame,
                                             uint16_t address,
                                             uint16_t count,
                                             uint8_t data)
{
    uint8_t *to = &frame->bytes[3];
    enum modbus_exception exception = check_range(address, count, data);

    if (exception != MODBUS_OK) {
        return exception;
    }
    if (ARE_WORDS(data)) {
        to = read_words(to, address, (uint8_t)count, data == READ_INPUT);
    } else {
        to = read_bits(to, address, (uint8_t)count, data);
    }
    frame->reply = (uint8_t)(to - frame->bytes);
    frame->bytes[2] = (uint8_t)(frame->reply - 3u);
    return MODBUS_OK;
}

// Write words or bits. `from`: the data in the request. The frame's size is the only limit of the
// quantity: the standard allows as many as fit a frame.
static APART enum modbus_exception write_data(uint16_t address,
                                              uint16_t count,
                                              uint8_t *from,
                                              uint8_t data)
{
    enum modbus_exception exception = check_range(address, count, data);

    if (exception != MODBUS_OK) {
        return exception;
    }
    return FEATURE_BITS && data == READ_COILS ? data_write_coils(address, count, from)
                                              : data_write(address, count, from);
}

#if FEATURE_DIAGNOSIS
// Serve function 22. The new word takes the place of the request's checksum; behind the checksum of
// a broadcast the buffer may already hold the next frame.
static enum modbus_exception mask_word(uint8_t *bytes, uint16_t address)
{
    uint16_t keep = get_word(&bytes[4]);
    uint16_t set = get_word(&bytes[6]);

    if (!data_holding_mapped(address, 1)) {
        return MODBUS_ILLEGAL_ADDRESS;
    }
    put_word(&bytes[8], (uint16_t)(((data_holding(address) ^ set) & keep) ^ set));
    return data_write(address, 1, &bytes[8]);
}

static enum modbus_exception write_and_read(struct frame *frame,
                                            uint16_t address,
                                            uint16_t count)
{
    uint8_t *bytes = frame->bytes;

    if (bytes[8] != 0 || bytes[9] == 0 || bytes[10] != 2u * bytes[9]) {
        return MODBUS_ILLEGAL_VALUE;
    }
    enum modbus_exception exception = check_range(address, count, READ_HOLDING);

    if (exception == MODBUS_OK) {
        exception = write_data(get_word(&bytes[6]), bytes[9], &bytes[11], READ_HOLDING);
    }
    return exception != MODBUS_OK ? exception
                                  : read_data(frame, address, count, READ_HOLDING);
}

#endif

static enum modbus_exception write_many(struct frame *frame,
                                        uint16_t address,
                                        uint16_t count)
{
    uint8_t *bytes = frame->bytes;
    bool words = !FEATURE_BITS || bytes[1] == WRITE_WORDS;
    uint8_t byte_count = bytes[6];

    frame->reply = REPLY_TO_WRITE;
    if (byte_count > WRITE_MAX_BYTES ||
        (words ? byte_count != (uint8_t)(2u * count)
               : (uint16_t)(8u * byte_count - count) >= 8u)) {
        return MODBUS_ILLEGAL_VALUE;
    }
    return write_data(address, count, &bytes[7], words ? READ_HOLDING : READ_COILS);
}

#if FEATURE_DIAGNOSIS
static bool known_diagnosis(uint8_t which)
{
    return which <= LAST_COUNTER && which != INPUT_DELIMITER &&
           (which <= LISTEN_ONLY || which >= CLEAR_COUNTERS);
}

// The data must be 0. A restart may also have FF00.
static bool right_data(const uint8_t *bytes)
{
    return bytes[5] == 0 && (bytes[4] == 0 || (bytes[4] == ON && bytes[3] == RESTART));
}

// Serve function 8: the reply is the request with a number in the place of its data.
static enum modbus_exception serve_diagnosis(struct frame *frame,
                                             struct server_counters *counters)
{
    uint8_t *bytes = frame->bytes;
    uint8_t which = bytes[3];
    uint16_t answer = 0;

    if (bytes[2] != 0 || !known_diagnosis(which)) {
        return MODBUS_ILLEGAL_FUNCTION;
    }
    if (which == LOOPBACK) {
        return MODBUS_OK;
    }
    if (frame->reply != REPLY_TO_WRITE || !right_data(bytes)) {
        return MODBUS_ILLEGAL_VALUE;
    }
    if (which >= FIRST_COUNTER) {
        answer = counters->all[which - FIRST_COUNTER];
    } else if (which == DIAGNOSTIC_REGISTER) {
        answer = data_input(REG_INPUT_status);
    } else if (which == LISTEN_ONLY) {
        counters->listen_only = true;
    } else {
        // Sub-functions 1 and 10 both clear the counters, and with them the listen-only mode. In
        // that mode only sub-function 1, which asks for its end, comes here.
        *counters = (struct server_counters){0};
        return MODBUS_OK;
    }
    put_word(&bytes[4], answer);
    return MODBUS_OK;
}

static enum modbus_exception serve_identity(struct frame *frame)
{
    uint8_t *bytes = frame->bytes;
    uint8_t text = data_identity(&bytes[5], IDENTITY_MAX);

    bytes[2] = (uint8_t)(text + 2u);
    bytes[3] = data_server_id();
    bytes[4] = data_running() ? ON : 0x00;
    frame->reply = (uint8_t)(5u + text);
    return MODBUS_OK;
}

// Write the words of the identity as objects of the reply: object `first` and those behind it, or
// object `first` alone.
static void put_objects(struct frame *frame, uint8_t first, bool one)
{
    uint8_t *bytes = frame->bytes;
    uint8_t *from = &bytes[IDENTITY_AT];
    uint8_t *to = &bytes[8];

    from[data_identity(from, IDENTITY_MAX)] = ' ';
    bytes[7] = 0; // objects
    for (uint8_t i = 0; i < DEVICE_OBJECTS; i++) {
        uint8_t *object = to;
        for (to += 2; *from != ' '; from++) {
            *to++ = *from;
        }
        from++;
        object[0] = i;
        object[1] = (uint8_t)(to - object - 2);
        if (i < first) {
            to = object;
            continue;
        }
        bytes[7]++;
        if (one) {
            break;
        }
    }
    frame->reply = (uint8_t)(to - bytes);
}

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
    bytes[4] = DEVICE_CONFORMS;
    bytes[5] = 0; // nothing follows
    bytes[6] = 0;
    put_objects(frame, first, one);
    return MODBUS_OK;
}

#endif

#if FEATURE_BITS
static enum modbus_exception write_coil(uint8_t *bytes, uint16_t address)
{
    if (bytes[5] != 0 || (uint8_t)(bytes[4] + 1u) > 1u) {
        return MODBUS_ILLEGAL_VALUE;
    }
    return write_data(address, 1, &bytes[4], READ_COILS);
}

#endif

// Serve a function that reads or writes data. `first` is the first address, and `second` is the
// quantity or a value.
static enum modbus_exception serve_data(struct frame *frame)
{
    uint8_t *bytes = frame->bytes;
    uint16_t first = get_word(&bytes[2]);
    uint16_t second = get_word(&bytes[4]);

    switch (bytes[1]) {
#if FEATURE_BITS
    case WRITE_COIL:
        return write_coil(bytes, first);
#endif
    case WRITE_WORD:
        // The word is written from a copy in the place of the checksum, so that the reply repeats
        // the word as it came.
        put_word(&bytes[6], second);
        return write_data(first, 1, &bytes[6], READ_HOLDING);
    case WRITE_COILS:
    case WRITE_WORDS:
        return write_many(frame, first, second);
#if FEATURE_DIAGNOSIS
    case MASK_WORD:
        return mask_word(bytes, first);
    case WRITE_AND_READ:
        return write_and_read(frame, first, second);
#endif
    default:
        return read_data(frame, first, second, bytes[1]);
    }
}

static enum modbus_exception serve_function(struct frame *frame,
                                            struct server_counters *counters)
{
    switch (frame->bytes[1]) {
#if FEATURE_DIAGNOSIS
    case DIAGNOSE:
        return serve_diagnosis(frame, counters);
    case IDENTIFY:
        return serve_identity(frame);
    case READ_DEVICE:
        return read_device(frame);
#endif
#if FEATURE_FILES
    case READ_FILES:
        return files_read(frame);
#endif
    default:
        (void)counters;
        return serve_data(frame);
    }
}

// Check the function, then the request's length, and serve the request. Most replies repeat the
// request and are as long as it is; the other functions set frame->reply.
static APART enum modbus_exception serve_checked(struct frame *frame,
                                                 uint8_t rule,
                                                 struct server_counters *counters)
{
    if ((rule & RULE_SERVED) == 0) {
        return MODBUS_ILLEGAL_FUNCTION;
    }
    if (frame->length != frame_length_by(frame, rule) &&
        !(FEATURE_DIAGNOSIS && frame->bytes[1] == DIAGNOSE)) {
        return MODBUS_ILLEGAL_VALUE;
    }
    frame->reply = (uint8_t)(frame->length - 2u);
    return serve_function(frame, counters);
}

static bool is_restart(const uint8_t *bytes)
{
    return FEATURE_DIAGNOSIS && bytes[1] == DIAGNOSE && bytes[2] == 0 &&
           bytes[3] == RESTART;
}

uint8_t server_serve(struct frame *frame, struct server_counters *counters)
{
    uint8_t *bytes = frame->bytes;
    uint8_t rule = frame_rule(bytes[1]);
    bool mute = server_listens_only(counters) || bytes[0] == 0;
    enum modbus_exception exception = MODBUS_OK;

    counters->frames_ok++;
    if ((bytes[0] != 0 || (rule & RULE_BROADCAST) != 0) &&
        (!server_listens_only(counters) || is_restart(bytes))) {
        exception = serve_checked(frame, rule, counters);
    }
    // The request may have begun the mode.
    if (mute || server_listens_only(counters)) {
        counters->no_replies++;
        return 0;
    }
    if (exception != MODBUS_OK) {
        counters->exceptions++;
        if (exception == MODBUS_BUSY) {
            counters->busy_replies++;
        }
        bytes[1] |= 0x80u;
        bytes[2] = (uint8_t)exception;
        return 3;
    }
    return frame->reply;
}
