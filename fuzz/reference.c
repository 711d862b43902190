// SPDX-License-Identifier: MIT
#include "reference.h"

#include <stddef.h>
#include <string.h>

#define ILLEGAL_FUNCTION 1u
#define ILLEGAL_ADDRESS  2u
#define ILLEGAL_VALUE    3u

// Reads and writes of the standard, at most.
#define READ_WORDS  125u
#define WRITE_WORDS 123u

struct asked {
    const uint8_t *bytes;
    uint16_t count;
    struct model *world;
    struct expected *expected;
};

static uint16_t word(const struct asked *asked, uint16_t at)
{
    return (uint16_t)(asked->bytes[at] * 256u + asked->bytes[at + 1u]);
}

static void reply_byte(struct expected *expected, uint16_t byte)
{
    expected->bytes[expected->count] = (uint8_t)byte;
    expected->count++;
}

static void reply_word(struct expected *expected, uint16_t value)
{
    reply_byte(expected, (uint16_t)(value >> 8));
    reply_byte(expected, value & 0xFFu);
}

static void reply_start(const struct asked *asked)
{
    asked->expected->count = 0;
    reply_byte(asked->expected, asked->bytes[0]);
    reply_byte(asked->expected, asked->bytes[1]);
}

// The reply repeats address, function and two words.
static void reply_echo(const struct asked *asked)
{
    reply_start(asked);
    reply_word(asked->expected, word(asked, 2));
    reply_word(asked->expected, word(asked, 4));
}

static uint8_t read_words(const struct asked *asked, bool input)
{
    if (asked->count != 6) {
        return ILLEGAL_VALUE;
    }
    uint16_t first = word(asked, 2);
    uint16_t number = word(asked, 4);

    if (number < 1 || number > READ_WORDS) {
        return ILLEGAL_VALUE;
    }
    if (!model_mapped(first, number)) {
        return ILLEGAL_ADDRESS;
    }
    reply_start(asked);
    reply_byte(asked->expected, (uint16_t)(2u * number));
    for (uint16_t i = 0; i < number; i++) {
        uint16_t at = (uint16_t)(first + i);
        reply_word(asked->expected,
                   input ? model_input(at) : model_holding(asked->world, at));
    }
    return 0;
}

static uint8_t read_holdings(const struct asked *asked)
{
    return read_words(asked, false);
}

static uint8_t read_inputs(const struct asked *asked)
{
    return read_words(asked, true);
}

static uint8_t write_one(const struct asked *asked)
{
    if (asked->count != 6) {
        return ILLEGAL_VALUE;
    }
    if (!model_mapped(word(asked, 2), 1)) {
        return ILLEGAL_ADDRESS;
    }
    reply_echo(asked);
    return model_write(asked->world, word(asked, 2), 1, &asked->bytes[4]);
}

static uint8_t write_many(const struct asked *asked)
{
    if (asked->count < 7) {
        return ILLEGAL_VALUE;
    }
    uint16_t number = word(asked, 4);

    if (number < 1 || number > WRITE_WORDS || asked->bytes[6] != 2u * number ||
        asked->count != 7u + 2u * number) {
        return ILLEGAL_VALUE;
    }
    if (!model_mapped(word(asked, 2), number)) {
        return ILLEGAL_ADDRESS;
    }
    reply_echo(asked);
    return model_write(asked->world, word(asked, 2), number, &asked->bytes[7]);
}

static uint8_t identify(const struct asked *asked)
{
    asked->expected->exact = false;
    return asked->count == 2 ? 0 : ILLEGAL_VALUE;
}

struct function {
    uint8_t code;
    bool writes; // so that it makes sense as a broadcast
    uint8_t (*serve)(const struct asked *asked);
};

static const struct function functions[] = {
    {3, false, read_holdings},
    {4, false, read_inputs},
    {6, true, write_one},
    {16, true, write_many},
    {17, false, identify},
};

static const struct function *function_of(uint8_t code)
{
    for (size_t i = 0; i < sizeof functions / sizeof functions[0]; i++) {
        if (functions[i].code == code) {
            return &functions[i];
        }
    }
    return NULL;
}

static void refuse(const struct asked *asked, uint8_t exception)
{
    struct expected *expected = asked->expected;

    expected->exact = true;
    expected->exception = exception;
    expected->count = 0;
    reply_byte(expected, asked->bytes[0]);
    reply_byte(expected, asked->bytes[1] | 0x80u);
    reply_byte(expected, exception);
}

void reference_serve(const uint8_t *request,
                     uint16_t count,
                     struct model *world,
                     struct expected *expected)
{
    struct asked asked = {
        .bytes = request, .count = count, .world = world, .expected = expected};
    const struct function *function = function_of(request[1]);
    bool broadcast = request[0] == 0;

    *expected = (struct expected){.exact = true};
    if (function == NULL) {
        refuse(&asked, ILLEGAL_FUNCTION);
    } else if (!broadcast || function->writes) {
        uint8_t exception = function->serve(&asked);
        if (exception != 0) {
            refuse(&asked, exception);
        }
    }
    if (broadcast) {
        *expected = (struct expected){.exact = true};
    }
}
