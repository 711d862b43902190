// SPDX-License-Identifier: MIT
// The holding registers of registers.def as a struct: defaults, ranges, access by address.
#pragma once

#include <stdbool.h>
#include <stdint.h>

typedef uint16_t settings_u16;
typedef uint32_t settings_u32;

struct settings {
#define INPUT(address, name, type, unit, meaning)
#define INPUT_AXIS(offset, name, type, unit, meaning)
#define HOLDING(address, name, type, unit, min, max, initial, meaning)                   \
    settings_##type name;
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
