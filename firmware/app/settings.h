// SPDX-License-Identifier: MIT
// The settings of registers.def: 16-bit words in the order of their addresses, so that a word is
// found by its address, and with a head and a checksum around them the record that is stored.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#define SETTINGS_VERSION 1u // of the record's layout
#define SETTINGS_ERASED  0xFFu

#define INPUT(address, name, type, unit, meaning)
#define INPUT_AXIS(offset, name, type, unit, meaning)
#define COMMAND(address, name, type, unit, min, max, initial, meaning)
#define FIELD_u16(name) uint16_t name;
#define FIELD_u32(name) uint16_t name[2]; // high word first
#define COUNT_u16       1u
#define COUNT_u32       2u

enum {
    SETTINGS_WORDS = 0
// NOLINTNEXTLINE(bugprone-macro-parentheses): the sum goes on from row to row
#define HOLDING(address, name, type, unit, min, max, initial, meaning) +COUNT_##type
#include "wire/registers.def"
#undef HOLDING
};

struct settings {
    uint8_t version; // SETTINGS_VERSION, of a record that is whole
    uint8_t bytes;   // of the record
    uint16_t serial; // number of the record: the higher one is newer
    union {
        struct {
#define HOLDING(address, name, type, unit, min, max, initial, meaning) FIELD_##type(name)
#include "wire/registers.def"
        };
        uint16_t words[SETTINGS_WORDS];
    };
    uint16_t checksum; // CRC-16 of everything before it
};
#undef HOLDING
#undef COMMAND
#undef INPUT
#undef INPUT_AXIS
#undef FIELD_u16
#undef FIELD_u32
#undef COUNT_u16
#undef COUNT_u32

const struct settings *settings_now(void);

// Every word at its default; the record's head stays.
void settings_set_defaults(void);

// The address strap of the board: 0 keeps the address setting, else overrides it until the next reset.
void settings_override_address(uint8_t address);

// All of them, the pixel frequency and the baud rate as a whole included.
bool settings_are_possible(void);

// `count` words from the first on change places with these, big-endian. What is possible then is
// the caller's question; a second call takes the exchange back.
void settings_exchange(uint8_t first, uint8_t count, uint8_t *words);

// The record as it is stored: for store.c alone.
struct settings *settings_record(void);

static inline uint32_t settings_u32(const uint16_t *words)
{
    return ((uint32_t)words[0] << 16) | words[1];
}
