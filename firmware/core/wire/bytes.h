// SPDX-License-Identifier: MIT
// Big-endian words in a byte buffer, and the halves of what two registers hold.
#pragma once

#include <stdbool.h>
#include <stdint.h>

_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__,
               "a word's low byte comes first");

// Through a union: of shifts avr-gcc makes one load and an exchange of its bytes.
static inline uint16_t get_word(const uint8_t *bytes)
{
    union {
        uint8_t byte[2];
        uint16_t word;
    } both = {.byte = {bytes[1], bytes[0]}};

    return both.word;
}

static inline void put_word(uint8_t *bytes, uint16_t word)
{
    bytes[0] = (uint8_t)(word >> 8);
    bytes[1] = (uint8_t)word;
}

// The word of a 32-bit value that its lower or its upper register holds.
static inline uint16_t half_word(uint32_t value, bool low)
{
    return (uint16_t)(low ? value : value >> 16);
}
