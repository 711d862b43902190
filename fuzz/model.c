// SPDX-License-Identifier: MIT
#include "model.h"

#include <string.h>

#include "fail.h"
#include "wire/server.h"

#define TAIL_BASE (0x10000u - MODEL_TAIL)

struct model model;

void model_reset(void)
{
    memset(&model, 0, sizeof model);
}

static uint16_t index_of(uint16_t address)
{
    return (uint16_t)(address < MODEL_WORDS ? address
                                            : MODEL_WORDS + (address - TAIL_BASE));
}

bool model_mapped(uint16_t address, uint16_t count)
{
    uint32_t end = (uint32_t)address + count;

    return end <= MODEL_WORDS || (address >= TAIL_BASE && end <= 0x10000u);
}

uint16_t model_input(uint16_t address)
{
    return (uint16_t)(address * 0x9E37u + 0x79B9u);
}

uint16_t model_holding(const struct model *at, uint16_t address)
{
    return at->words[index_of(address)];
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
        uint8_t refusal = refusal_of(word_at(&words[2u * i]));
        if (refusal != MODBUS_OK) {
            return refusal;
        }
    }
    for (uint16_t i = 0; i < count; i++) {
        at->words[index_of((uint16_t)(address + i))] = word_at(&words[2u * i]);
    }
    return MODBUS_OK;
}

// The server's contract: it asks for what is mapped only.
static void must_be_mapped(uint16_t address, uint16_t count)
{
    PROMISE(count != 0 && model_mapped(address, count),
            "the server used %u words at 0x%04X, which are not mapped",
            (unsigned)count,
            (unsigned)address);
}

bool data_input_mapped(uint16_t address, uint16_t count)
{
    return model_mapped(address, count);
}

uint16_t data_input(uint16_t address)
{
    must_be_mapped(address, 1);
    return model_input(address);
}

bool data_holding_mapped(uint16_t address, uint16_t count)
{
    return model_mapped(address, count);
}

uint16_t data_holding(uint16_t address)
{
    must_be_mapped(address, 1);
    return model_holding(&model, address);
}

enum modbus_exception data_write(uint16_t address, uint16_t count, const uint8_t *words)
{
    must_be_mapped(address, count);
    return (enum modbus_exception)model_write(&model, address, count, words);
}

uint8_t data_identity(uint8_t *text, uint8_t room)
{
    memset(text, 'x', room);
    return room;
}

bool data_running(void)
{
    return true;
}

uint8_t data_server_id(void)
{
    return 42;
}
