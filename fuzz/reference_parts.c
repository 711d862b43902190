// SPDX-License-Identifier: MIT
#include "reference_parts.h"

#include <string.h>

#define FILE_BYTES   7u // bytes of one part of a request of function 20
#define FILE_REPLY   0xF5u
#define FILE_KIND    6u
#define RECORD_MAX   9999u
#define DEVICE_KIND  14u
#define OBJECTS      3u
#define CONFORMS     0x81u
#define INDIVIDUALLY 4u

uint16_t asked_word(const struct asked *asked, uint16_t at)
{
    return (uint16_t)(asked->bytes[at] * 256u + asked->bytes[at + 1u]);
}

void reply_byte(struct expected *expected, uint16_t byte)
{
    expected->bytes[expected->count] = (uint8_t)byte;
    expected->count++;
}

void reply_word(struct expected *expected, uint16_t value)
{
    reply_byte(expected, (uint16_t)(value >> 8));
    reply_byte(expected, value & 0xFFu);
}

void reply_text(struct expected *expected, const char *text, uint8_t length)
{
    for (uint8_t i = 0; i < length; i++) {
        reply_byte(expected, (uint8_t)text[i]);
    }
}

void reply_start(const struct asked *asked)
{
    asked->expected->count = 0;
    reply_byte(asked->expected, asked->bytes[0]);
    reply_byte(asked->expected, asked->bytes[1]);
}

void reply_echo(const struct asked *asked, uint16_t count)
{
    asked->expected->count = 0;
    for (uint16_t i = 0; i < count; i++) {
        reply_byte(asked->expected, asked->bytes[i]);
    }
}

void reply_data(const struct asked *asked, uint16_t address, bool input)
{
    reply_word(asked->expected,
               input ? model_input(address) : model_holding(asked->world, address));
}

static bool known_diagnosis(uint16_t which)
{
    return which <= 2 || which == 4 || (which >= 10 && which <= 18);
}

static bool diagnosis_well_formed(const struct asked *asked, uint16_t which)
{
    uint16_t data = asked->count == 6 ? asked_word(asked, 4) : 1;

    return data == 0 || (which == 1 && data == 0xFF00u);
}

uint8_t reference_diagnose(const struct asked *asked)
{
    uint16_t which = asked->count < 4 ? 0xFFFFu : asked_word(asked, 2);

    if (!known_diagnosis(which)) {
        return ILLEGAL_FUNCTION;
    }
    if (which != 0 && !diagnosis_well_formed(asked, which)) {
        return ILLEGAL_VALUE;
    }
    reply_echo(asked, asked->count);
    if (which == 1) {
        asked->world->listen_only = false;
    } else if (which == 4) {
        asked->world->listen_only = true;
    } else if (which == 2 || which >= 11) {
        asked->expected->counted = true;
    }
    return 0;
}

uint8_t reference_identify(const struct asked *asked)
{
    uint8_t length = sizeof MODEL_IDENTITY - 1u;

    if (asked->count != 2) {
        return ILLEGAL_VALUE;
    }
    reply_start(asked);
    reply_byte(asked->expected, length + 2u);
    reply_byte(asked->expected, MODEL_SERVER_ID);
    reply_byte(asked->expected, 0xFF);
    reply_text(asked->expected, MODEL_IDENTITY, length);
    return 0;
}

// The registers at which files 1 to 3 begin.
static const uint16_t starts[] = {0, 0x0100, 0x0300, 0};

static bool part_mapped(const struct asked *asked, uint16_t at)
{
    uint16_t file = asked_word(asked, (uint16_t)(at + 1u));
    uint16_t record = asked_word(asked, (uint16_t)(at + 3u));
    uint16_t words = asked_word(asked, (uint16_t)(at + 5u));

    if (asked->bytes[at] != FILE_KIND || file < 1 || file > 3 || record > RECORD_MAX) {
        return false;
    }
    return model_mapped(
        file == 3 ? MODEL_WORDS : MODEL_INPUTS, (uint16_t)(starts[file] + record), words);
}

static void reply_part(const struct asked *asked, uint16_t at)
{
    uint16_t file = asked_word(asked, (uint16_t)(at + 1u));
    uint16_t words = asked_word(asked, (uint16_t)(at + 5u));

    reply_byte(asked->expected, (uint16_t)(2u * words + 1u));
    reply_byte(asked->expected, FILE_KIND);
    for (uint16_t i = 0; i < words; i++) {
        uint16_t address =
            (uint16_t)(starts[file] + asked_word(asked, (uint16_t)(at + 3u)) + i);
        reply_data(asked, address, file != 3);
    }
}

// The number of bytes of the replies to all parts; too large a number when a quantity is out of
// range.
static uint32_t parts_bytes(const struct asked *asked)
{
    uint32_t bytes = 0;

    for (uint16_t at = 3; at < asked->count; at = (uint16_t)(at + FILE_BYTES)) {
        uint16_t words = asked_word(asked, (uint16_t)(at + 5u));
        bytes += words == 0 ? FILE_REPLY + 1u : 2u + 2u * (uint32_t)words;
    }
    return bytes;
}

uint8_t reference_read_files(const struct asked *asked)
{
    if (asked->count < 3 || asked->count != 3u + asked->bytes[2] ||
        asked->bytes[2] < FILE_BYTES || asked->bytes[2] > FILE_REPLY ||
        asked->bytes[2] % FILE_BYTES != 0) {
        return ILLEGAL_VALUE;
    }
    uint32_t bytes = parts_bytes(asked);

    if (bytes > FILE_REPLY) {
        return ILLEGAL_VALUE;
    }
    for (uint16_t at = 3; at < asked->count; at = (uint16_t)(at + FILE_BYTES)) {
        if (!part_mapped(asked, at)) {
            return ILLEGAL_ADDRESS;
        }
    }
    reply_start(asked);
    reply_byte(asked->expected, (uint16_t)bytes);
    for (uint16_t at = 3; at < asked->count; at = (uint16_t)(at + FILE_BYTES)) {
        reply_part(asked, at);
    }
    return 0;
}

static void reply_objects(const struct asked *asked, uint8_t first, uint8_t last)
{
    static const char *const texts[OBJECTS] = {"maker", "thing", "1.0"};

    reply_byte(asked->expected, (uint16_t)(last - first + 1u));
    for (uint8_t i = first; i <= last; i++) {
        uint8_t length = (uint8_t)strlen(texts[i]);
        reply_byte(asked->expected, i);
        reply_byte(asked->expected, length);
        reply_text(asked->expected, texts[i], length);
    }
}

uint8_t reference_read_device(const struct asked *asked)
{
    if (asked->count != 5) {
        return ILLEGAL_VALUE;
    }
    uint8_t code = asked->bytes[3];
    uint8_t object = asked->bytes[4];

    if (asked->bytes[2] != DEVICE_KIND) {
        return ILLEGAL_FUNCTION;
    }
    if (code < 1 || code > INDIVIDUALLY) {
        return ILLEGAL_VALUE;
    }
    if (object >= OBJECTS) {
        if (code == INDIVIDUALLY) {
            return ILLEGAL_ADDRESS;
        }
        object = 0;
    }
    reply_echo(asked, 4);
    reply_byte(asked->expected, CONFORMS);
    reply_byte(asked->expected, 0);
    reply_byte(asked->expected, 0);
    reply_objects(asked, object, code == INDIVIDUALLY ? object : OBJECTS - 1u);
    return 0;
}
