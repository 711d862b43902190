// SPDX-License-Identifier: MIT
#include "app/settings.h"

#define INPUT(address, name, type, unit, meaning)
#define INPUT_AXIS(offset, name, type, unit, meaning)

void settings_defaults(struct settings *settings)
{
#define HOLDING(address, name, type, unit, min, max, initial, meaning)                   \
    settings->name = (initial);
#include "wire/registers.def"
#undef HOLDING
}

static bool in_range(uint32_t value, uint32_t min, uint32_t max)
{
    return value >= min && value <= max;
}

bool settings_in_range(const struct settings *settings)
{
    bool ok = true;

#define HOLDING(address, name, type, unit, min, max, initial, meaning)                   \
    ok = ok && in_range(settings->name, (min), (max));
#include "wire/registers.def"
#undef HOLDING
    return ok;
}

#define GET_u16(address, name)                                                           \
    case (address):                                                                      \
        *word = settings->name;                                                          \
        return true;
#define GET_u32(address, name)                                                           \
    case (address):                                                                      \
        *word = (uint16_t)(settings->name >> 16);                                        \
        return true;                                                                     \
    case (address) + 1:                                                                  \
        *word = (uint16_t)settings->name;                                                \
        return true;

bool settings_get(const struct settings *settings, uint16_t address, uint16_t *word)
{
    switch (address) {
#define HOLDING(address, name, type, unit, min, max, initial, meaning)                   \
    GET_##type(address, name)
#include "wire/registers.def"
#undef HOLDING
    default:
        return false;
    }
}

enum settings_bits {
#define HOLDING(address, name, type, unit, min, max, initial, meaning)                   \
    BITS_##name = SETTINGS_BITS(max),
#include "wire/registers.def"
#undef HOLDING
};

#define MASK(name) (0xFFFFu >> (16 - BITS_##name))

static uint16_t fit(uint16_t word, uint16_t mask)
{
    return word > mask ? mask : word;
}

#define SET_u16(address, name)                                                           \
    case (address):                                                                      \
        settings->name = fit(word, MASK(name)) & MASK(name);                             \
        return true;
#define SET_u32(address, name)                                                           \
    case (address):                                                                      \
        settings->name = (settings->name & 0xFFFFuL) | ((uint32_t)word << 16);           \
        return true;                                                                     \
    case (address) + 1:                                                                  \
        settings->name = (settings->name & 0xFFFF0000uL) | word;                         \
        return true;

bool settings_set(struct settings *settings, uint16_t address, uint16_t word)
{
    switch (address) {
#define HOLDING(address, name, type, unit, min, max, initial, meaning)                   \
    SET_##type(address, name)
#include "wire/registers.def"
#undef HOLDING
    default:
        return false;
    }
}
