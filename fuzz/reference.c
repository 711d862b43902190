// SPDX-License-Identifier: MIT
#include "reference.h"

#include <stddef.h>
#include <string.h>

#include "reference_parts.h"

#define READ_BITS   2000u
#define READ_WORDS  125u
#define WRITE_BITS  1968u
#define WRITE_WORDS 123u
#define BOTH_WORDS  121u // most words that function 23 writes

static uint8_t check(uint16_t number, uint32_t most, bool mapped)
{
    if (number < 1 || number > most) {
        return ILLEGAL_VALUE;
    }
    return mapped ? 0 : ILLEGAL_ADDRESS;
}

static bool bit_at(const struct asked *asked, uint16_t address)
{
    return asked->bytes[1] == 1 ? model_coil(asked->world, address)
                                : model_discrete(address);
}

static uint8_t read_bits(const struct asked *asked)
{
    if (asked->count != 6) {
        return ILLEGAL_VALUE;
    }
    uint16_t first = asked_word(asked, 2);
    uint16_t number = asked_word(asked, 4);
    uint8_t exception = check(number, READ_BITS, model_mapped(MODEL_BITS, first, number));

    if (exception != 0) {
        return exception;
    }
    reply_start(asked);
    reply_byte(asked->expected, (uint16_t)((number + 7u) / 8u));
    for (uint16_t i = 0; i < number; i += 8) {
        uint16_t byte = 0;
        for (uint16_t bit = 0; bit < 8 && i + bit < number; bit++) {
            if (bit_at(asked, (uint16_t)(first + i + bit))) {
                byte = (uint16_t)(byte | 1u << bit);
            }
        }
        reply_byte(asked->expected, byte);
    }
    return 0;
}

static void reply_words(const struct asked *asked,
                        uint16_t first,
                        uint16_t number,
                        bool input)
{
    reply_start(asked);
    reply_byte(asked->expected, (uint16_t)(2u * number));
    for (uint16_t i = 0; i < number; i++) {
        reply_data(asked, (uint16_t)(first + i), input);
    }
}

static uint8_t read_words(const struct asked *asked)
{
    bool input = asked->bytes[1] == 4;

    if (asked->count != 6) {
        return ILLEGAL_VALUE;
    }
    uint16_t first = asked_word(asked, 2);
    uint16_t number = asked_word(asked, 4);
    uint8_t exception =
        check(number,
              READ_WORDS,
              model_mapped(input ? MODEL_INPUTS : MODEL_WORDS, first, number));

    if (exception == 0) {
        reply_words(asked, first, number, input);
    }
    return exception;
}

static uint8_t write_coil(const struct asked *asked)
{
    if (asked->count != 6 || (asked_word(asked, 4) & 0x00FFu) != 0 ||
        (asked->bytes[4] != 0 && asked->bytes[4] != 0xFF)) {
        return ILLEGAL_VALUE;
    }
    if (!model_mapped(MODEL_BITS, asked_word(asked, 2), 1)) {
        return ILLEGAL_ADDRESS;
    }
    reply_echo(asked, 6);
    return model_write_coils(asked->world, asked_word(asked, 2), 1, &asked->bytes[4]);
}

static uint8_t write_word(const struct asked *asked)
{
    if (asked->count != 6) {
        return ILLEGAL_VALUE;
    }
    if (!model_mapped(MODEL_WORDS, asked_word(asked, 2), 1)) {
        return ILLEGAL_ADDRESS;
    }
    reply_echo(asked, 6);
    return model_write(asked->world, asked_word(asked, 2), 1, &asked->bytes[4]);
}

// True when the byte count and the length of a write agree with its quantity.
static bool counts_agree(const struct asked *asked, uint32_t bytes)
{
    return asked->bytes[6] == bytes && asked->count == 7u + bytes;
}

static uint8_t write_coils(const struct asked *asked)
{
    if (asked->count < 7) {
        return ILLEGAL_VALUE;
    }
    uint16_t first = asked_word(asked, 2);
    uint16_t number = asked_word(asked, 4);

    if (!counts_agree(asked, (number + 7u) / 8u)) {
        return ILLEGAL_VALUE;
    }
    uint8_t exception =
        check(number, WRITE_BITS, model_mapped(MODEL_BITS, first, number));

    reply_echo(asked, 6);
    return exception != 0
               ? exception
               : model_write_coils(asked->world, first, number, &asked->bytes[7]);
}

static uint8_t write_words(const struct asked *asked)
{
    if (asked->count < 7) {
        return ILLEGAL_VALUE;
    }
    uint16_t first = asked_word(asked, 2);
    uint16_t number = asked_word(asked, 4);

    if (!counts_agree(asked, 2u * number)) {
        return ILLEGAL_VALUE;
    }
    uint8_t exception =
        check(number, WRITE_WORDS, model_mapped(MODEL_WORDS, first, number));

    reply_echo(asked, 6);
    return exception != 0 ? exception
                          : model_write(asked->world, first, number, &asked->bytes[7]);
}

static uint8_t mask_word(const struct asked *asked)
{
    if (asked->count != 8) {
        return ILLEGAL_VALUE;
    }
    uint16_t address = asked_word(asked, 2);

    if (!model_mapped(MODEL_WORDS, address, 1)) {
        return ILLEGAL_ADDRESS;
    }
    uint16_t and_mask = asked_word(asked, 4);
    uint16_t or_mask = asked_word(asked, 6);
    uint16_t now = model_holding(asked->world, address);
    uint16_t wanted = (uint16_t)((now & and_mask) | (or_mask & ~and_mask));
    uint8_t bytes[2] = {(uint8_t)(wanted >> 8), (uint8_t)wanted};

    reply_echo(asked, 8);
    return model_write(asked->world, address, 1, bytes);
}

static bool both_numbers_agree(const struct asked *asked, uint16_t read, uint16_t write)
{
    return read >= 1 && read <= READ_WORDS && write >= 1 && write <= BOTH_WORDS &&
           asked->bytes[10] == 2u * write && asked->count == 11u + 2u * write;
}

// Check the read part, then the write part, both before anything is done.
static uint8_t write_and_read(const struct asked *asked)
{
    if (asked->count < 11) {
        return ILLEGAL_VALUE;
    }
    uint16_t read = asked_word(asked, 2);
    uint16_t read_number = asked_word(asked, 4);
    uint16_t write = asked_word(asked, 6);
    uint16_t write_number = asked_word(asked, 8);

    if (!both_numbers_agree(asked, read_number, write_number)) {
        return ILLEGAL_VALUE;
    }
    if (!model_mapped(MODEL_WORDS, read, read_number) ||
        !model_mapped(MODEL_WORDS, write, write_number)) {
        return ILLEGAL_ADDRESS;
    }
    uint8_t exception = model_write(asked->world, write, write_number, &asked->bytes[11]);

    if (exception == 0) {
        reply_words(asked, read, read_number, false);
    }
    return exception;
}

struct function {
    uint8_t code;
    bool writes; // the function writes, so that it may be a broadcast
    uint8_t (*serve)(const struct asked *asked);
};

static const struct function functions[] = {
    {1, false, read_bits},
    {2, false, read_bits},
    {3, false, read_words},
    {4, false, read_words},
    {5, true, write_coil},
    {6, true, write_word},
    {8, false, reference_diagnose},
    {15, true, write_coils},
    {16, true, write_words},
    {17, false, reference_identify},
    {20, false, reference_read_files},
    {22, true, mask_word},
    {23, false, write_and_read},
    {43, false, reference_read_device},
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

    expected->count = 0;
    expected->counted = false;
    reply_byte(expected, asked->bytes[0]);
    reply_byte(expected, asked->bytes[1] | 0x80u);
    reply_byte(expected, exception);
}

static void serve(const struct asked *asked)
{
    const struct function *function = function_of(asked->bytes[1]);

    if (function == NULL) {
        refuse(asked, ILLEGAL_FUNCTION);
    } else if (asked->bytes[0] != 0 || function->writes) {
        uint8_t exception = function->serve(asked);
        if (exception != 0) {
            refuse(asked, exception);
        }
    }
}

static bool ends_listening(const struct asked *asked)
{
    static const uint8_t restart[] = {8, 0, 1};

    return asked->bytes[0] != 0 && asked->count >= 4 &&
           memcmp(&asked->bytes[1], restart, sizeof restart) == 0;
}

void reference_serve(const uint8_t *request,
                     uint16_t count,
                     struct model *world,
                     struct expected *expected)
{
    struct asked asked = {
        .bytes = request, .count = count, .world = world, .expected = expected};
    bool silent = request[0] == 0 || world->listen_only;

    *expected = (struct expected){.count = 0};
    if (!world->listen_only || ends_listening(&asked)) {
        serve(&asked);
    }
    if (silent || world->listen_only) {
        *expected = (struct expected){.count = 0};
    }
}
