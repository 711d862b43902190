// SPDX-License-Identifier: MIT
#include "model.h"

#include <stddef.h>
#include <string.h>

#include "promise.h"
#include "wire/bytes.h"
#include "wire/server.h"
#include "wire/server_data.h"

#define TAIL_BASE (0x10000u - MODEL_TAIL)

struct model model;

void model_reset(void)
{
    memset(&model, 0, sizeof model);
}

bool model_same(const struct model *one, const struct model *other)
{
    return memcmp(one->words, other->words, sizeof one->words) == 0 &&
           memcmp(one->coils, other->coils, sizeof one->coils) == 0 &&
           one->listen_only == other->listen_only;
}

static uint16_t index_of(uint16_t address, uint16_t from_start)
{
    return (uint16_t)(address < from_start ? address : from_start + address % MODEL_TAIL);
}

bool model_mapped(uint32_t from_start, uint16_t address, uint16_t count)
{
    uint32_t end = (uint32_t)address + count;

    return end <= from_start || (address >= TAIL_BASE && end <= 0x10000u);
}

uint16_t model_input(uint16_t address)
{
    return (uint16_t)(address * 0x9E37u + 0x79B9u);
}

uint16_t model_holding(const struct model *at, uint16_t address)
{
    return at->words[index_of(address, MODEL_WORDS)];
}

bool model_coil(const struct model *at, uint16_t address)
{
    return at->coils[index_of(address, MODEL_BITS)];
}

bool model_discrete(uint16_t address)
{
    return (model_input(address) & 0x20u) != 0;
}

static uint16_t word_at(const uint8_t *bytes)
{
    return (uint16_t)(((uint16_t)bytes[0] << 8) | bytes[1]);
}

static uint8_t refusal_of(uint16_t word)
{
    switch (word) {
    case MODEL_ILLEGAL:
        return MODBUS_ILLEGAL_VALUE;
    case MODEL_BUSY:
        return MODBUS_BUSY;
    case MODEL_FAILS:
        return MODBUS_DEVICE_FAILURE;
    default:
        return MODBUS_OK;
    }
}

uint8_t model_write(struct model *at,
                    uint16_t address,
                    uint16_t count,
                    const uint8_t *words)
{
    for (uint16_t i = 0; i < count; i++) {
        uint8_t refusal = refusal_of(word_at(&words[2 * (size_t)i]));
        if (refusal != MODBUS_OK) {
            return refusal;
        }
    }
    for (uint16_t i = 0; i < count; i++) {
        uint16_t index = index_of((uint16_t)(address + i), MODEL_WORDS);
        at->words[index] = word_at(&words[2 * (size_t)i]);
    }
    return MODBUS_OK;
}

static bool bit_of(const uint8_t *bits, uint16_t number)
{
    return ((uint8_t)(bits[number / 8u] >> (number % 8u)) & 1u) != 0;
}

uint8_t model_write_coils(struct model *at,
                          uint16_t address,
                          uint16_t count,
                          const uint8_t *bits)
{
    for (uint16_t i = 0; i < count; i++) {
        if ((uint16_t)(address + i) == MODEL_STUCK_COIL && bit_of(bits, i)) {
            return MODBUS_DEVICE_FAILURE;
        }
    }
    for (uint16_t i = 0; i < count; i++) {
        at->coils[index_of((uint16_t)(address + i), MODEL_BITS)] = bit_of(bits, i);
    }
    return MODBUS_OK;
}

// By its contract the server asks only for addresses that are mapped.
static void must_be_mapped(uint32_t from_start, uint16_t address, uint16_t count)
{
    promise(count != 0 && model_mapped(from_start, address, count),
            "the server used %u at 0x%04X, which are not mapped",
            (unsigned)count,
            (unsigned)address);
}

bool data_input_mapped(uint16_t address, uint16_t count)
{
    return model_mapped(MODEL_INPUTS, address, count);
}

uint16_t data_input(uint16_t address)
{
    must_be_mapped(MODEL_INPUTS, address, 1);
    return model_input(address);
}

uint8_t data_inputs(uint16_t address, uint8_t count, uint8_t *to)
{
    uint8_t together = (uint8_t)(address % 5u);

    if (together > count) {
        return 0;
    }
    for (uint8_t i = 0; i < together; i++, to += 2) {
        put_word(to, data_input((uint16_t)(address + i)));
    }
    return together;
}

bool data_holding_mapped(uint16_t address, uint16_t count)
{
    return model_mapped(MODEL_WORDS, address, count);
}

uint16_t data_holding(uint16_t address)
{
    must_be_mapped(MODEL_WORDS, address, 1);
    return model_holding(&model, address);
}

enum modbus_exception data_write(uint16_t address, uint16_t count, uint8_t *words)
{
    must_be_mapped(MODEL_WORDS, address, count);
    return (enum modbus_exception)model_write(&model, address, count, words);
}

bool data_bits_mapped(uint16_t address, uint16_t count, uint8_t which)
{
    promise(
        which == SERVER_COILS || which == SERVER_DISCRETE, "bits %u", (unsigned)which);
    return model_mapped(MODEL_BITS, address, count);
}

bool data_bit(uint16_t address, uint8_t which)
{
    must_be_mapped(MODEL_BITS, address, 1);
    return which == SERVER_COILS ? model_coil(&model, address) : model_discrete(address);
}

enum modbus_exception data_write_coils(uint16_t address,
                                       uint16_t count,
                                       const uint8_t *bits)
{
    must_be_mapped(MODEL_BITS, address, count);
    return (enum modbus_exception)model_write_coils(&model, address, count, bits);
}

uint8_t data_identity(uint8_t *text, uint8_t room)
{
    static const char identity[] = MODEL_IDENTITY;

    promise(room >= sizeof identity, "only %u bytes of identity", (unsigned)room);
    memcpy(text, identity, sizeof identity - 1u);
    return sizeof identity - 1u;
}

bool data_running(void)
{
    return true;
}

uint8_t data_server_id(void)
{
    return MODEL_SERVER_ID;
}
