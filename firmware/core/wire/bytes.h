// SPDX-License-Identifier: MIT
// Big-endian words in a byte buffer, and the two words of a 32-bit value.
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

// Write the word to bytes[0] (high) and bytes[1] (low).
static inline void put_word(uint8_t *bytes, uint16_t word)
{
    bytes[0] = (uint8_t)(word >> 8);
    bytes[1] = (uint8_t)word;
}

// The lower word of a 32-bit value, or its upper word: what one of its two registers holds.
static inline uint16_t half_word(uint32_t value, bool low)
{
    return (uint16_t)(low ? value : value >> 16);
}
