// SPDX-License-Identifier: MIT
#include "wire/files.h"

#include "build_features.h"    // FEATURE_FILES
#include "wire/bytes.h"        // get_word, put_word
#include "wire/read_words.h"   // read_words
#include "wire/register_map.h" // REG_*

#if FEATURE_FILES

#define COUNT_AT 2u // place of the number of bytes of all requests, or of all replies
#define FIRST_AT 3u
#define REQUEST_BYTES 7u // bytes of a request: kind, file, record, number of words
#define BYTES_MIN     7u
#define BYTES_MAX     0xF5u
#define KIND          6u
#define RECORD_MAX    9999u
#define FILES         3u
#define SETTINGS_FILE 3u
#define REPLY_HEADER  2u // bytes before the words of a reply: length, kind

// A plan is what is kept of a request that was found right: number of words, then first register.
#define PLAN_BYTES   3u
#define PLAN_HOLDING 0x80u

// The first register of a file.
static uint16_t file_start(uint16_t file)
{
    static const uint16_t starts[FILES] = {REG_RECORD_BASE, REG_EVENT_BASE, 0u};

    return starts[file - 1u];
}

static bool record_mapped(const uint8_t *request)
{
    uint16_t file = get_word(&request[1]);
    uint16_t record = get_word(&request[3]);
    uint16_t words = get_word(&request[5]);

    if (request[0] != KIND || file == 0 || file > FILES || record > RECORD_MAX) {
        return false;
    }
    uint16_t address = (uint16_t)(file_start(file) + record);

    return file == SETTINGS_FILE ? data_holding_mapped(address, words)
                                 : data_input_mapped(address, words);
}

static void plan_reply(uint8_t *to, const uint8_t *request)
{
    uint16_t file = get_word(&request[1]);
    uint16_t address = (uint16_t)(file_start(file) + get_word(&request[3]));

    to[0] = (uint8_t)(request[6] | (file == SETTINGS_FILE ? PLAN_HOLDING : 0u));
    put_word(&to[1], address);
}

// Write one reply from its plan. Returns the byte behind the reply.
static uint8_t *write_reply(uint8_t *to, const uint8_t *planned)
{
    bool holding = (planned[0] & PLAN_HOLDING) != 0;
    uint8_t words = (uint8_t)(planned[0] & (PLAN_HOLDING - 1u));
    uint16_t address = get_word(&planned[1]);

    to[0] = (uint8_t)(2u * words + 1u);
    to[1] = KIND;
    return read_words(&to[REPLY_HEADER], address, words, !holding);
}

// Check all quantities, then the addresses. *reply_bytes gets the number of bytes of all replies.
static enum modbus_exception check_requests(const uint8_t *bytes, uint16_t *reply_bytes)
{
    enum modbus_exception found = MODBUS_OK;
    uint8_t count = bytes[COUNT_AT];

    *reply_bytes = 0;
    if (count < BYTES_MIN || count > BYTES_MAX || count % REQUEST_BYTES != 0) {
        return MODBUS_ILLEGAL_VALUE;
    }
    for (uint8_t i = FIRST_AT; i < FIRST_AT + count; i = (uint8_t)(i + REQUEST_BYTES)) {
        uint16_t words = get_word(&bytes[i + 5u]);

        if (words == 0 || words > BYTES_MAX / 2u) {
            return MODBUS_ILLEGAL_VALUE;
        }
        *reply_bytes = (uint16_t)(*reply_bytes + REPLY_HEADER + 2u * words);
        if (!record_mapped(&bytes[i])) {
            found = MODBUS_ILLEGAL_ADDRESS;
        }
    }
    return *reply_bytes > BYTES_MAX ? MODBUS_ILLEGAL_VALUE : found;
}

enum modbus_exception files_read(struct frame *frame)
{
    uint8_t *bytes = frame->bytes;
    uint16_t reply_bytes = 0;
    enum modbus_exception exception = check_requests(bytes, &reply_bytes);
    uint8_t requests = (uint8_t)(bytes[COUNT_AT] / REQUEST_BYTES);

    if (exception != MODBUS_OK) {
        return exception;
    }
    // The replies overwrite the requests and may be longer than those. The requests are therefore
    // shortened to plans, and the plans are moved to the end of the buffer. A reply has at least 4
    // bytes, a plan has 3, and all replies together end 8 bytes before the buffer does: no reply
    // reaches a plan that is still needed.
    for (uint8_t i = 0; i < requests; i++) {
        plan_reply(&bytes[FIRST_AT + i * PLAN_BYTES],
                   &bytes[FIRST_AT + i * REQUEST_BYTES]);
    }
    const uint8_t *planned = &bytes[FRAME_MAX_BYTES - requests * PLAN_BYTES];
    for (uint8_t i = (uint8_t)(requests * PLAN_BYTES); i != 0;) {
        i--;
        bytes[FRAME_MAX_BYTES - requests * PLAN_BYTES + i] = bytes[FIRST_AT + i];
    }
    uint8_t *to = &bytes[FIRST_AT];
    for (uint8_t i = 0; i < requests; i++) {
        to = write_reply(to, planned);
        planned += PLAN_BYTES;
    }
    bytes[COUNT_AT] = (uint8_t)reply_bytes;
    frame->reply = (uint8_t)(to - bytes);
    return MODBUS_OK;
}

#endif
