// SPDX-License-Identifier: MIT
// Big-endian words in a byte buffer, and the two words of a 32-bit value.
//
//     bytes      | 12 | 34 | 56 | 78 |        as Modbus sends them: high byte first
//     words      |  1234   |  5678   |        get_word(), put_word()
//     32 bits    |     12345678      |        half_word(): false 1234, true 5678
//
// Requests, replies and files hold their words so. The functions check no length: the caller knows
// that the bytes are there. They have no state and may be called from any context.
#pragma once

#include <stdbool.h>
#include <stdint.h>

// get_word() puts its two bytes into a union in this order.
_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__,
               "a word's low byte comes first");

// The word at bytes[0] (high) and bytes[1] (low), at any address. The function uses a union instead
// of shifts, because avr-gcc turns shifts into one load and an exchange of the two bytes.
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

// The lower word (low: true) or the upper word of a 32-bit value: what one of the value's two
// registers shows. Every 32-bit value takes two registers, the upper word at the lower address.
static inline uint16_t half_word(uint32_t value, bool low)
{
    return (uint16_t)(low ? value : value >> 16);
}
