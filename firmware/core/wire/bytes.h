// SPDX-License-Identifier: MIT
// Big-endian words in a byte buffer.
#pragma once

#include <stdint.h>

static inline uint16_t get_word(const uint8_t *bytes)
{
    return (uint16_t)(((uint16_t)bytes[0] << 8) | bytes[1]);
}

static inline void put_word(uint8_t *bytes, uint16_t word)
{
    bytes[0] = (uint8_t)(word >> 8);
    bytes[1] = (uint8_t)word;
}
