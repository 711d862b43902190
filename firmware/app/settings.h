// SPDX-License-Identifier: MIT
// The holding registers of registers.def as a struct: defaults, ranges, access by address.
#pragma once

#include <stdbool.h>
#include <stdint.h>

// Where a byte holds the range it is all that is kept: 255, which is in no such range, stands for
// everything above it.
#define SETTINGS_BITS(max) ((max) < 255 ? 8 : (max) <= 0xFFFFuL ? 16 : 32)

struct settings {
#define INPUT(address, name, type, unit, meaning)
#define INPUT_AXIS(offset, name, type, unit, meaning)
#define HOLDING(address, name, type, unit, min, max, initial, meaning)                   \
    uint32_t name : SETTINGS_BITS(max);
#include "wire/registers.def"
#undef INPUT
#undef INPUT_AXIS
#undef HOLDING
};

void settings_defaults(struct settings *settings);
bool settings_in_range(const struct settings *settings);

// One 16-bit word by register address; false when nothing is mapped there.
bool settings_get(const struct settings *settings, uint16_t address, uint16_t *word);
bool settings_set(struct settings *settings, uint16_t address, uint16_t word);
