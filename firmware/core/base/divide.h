// SPDX-License-Identifier: MIT
// Quotients for which avr-gcc needs three times as long: assembly there. The C that the assembly
// stands for is beside it; every other compiler gets the C.
//
//     function              dividend    divisor    result
//     divide_u32_u16()      32 bits     16 bits    quotient, 16 bits
//     divide_with_rest()    2 x 16      16 bits    quotient and rest, 16 bits each
//     divide_product()      32 x 32     32 bits    quotient and rest, 32 bits each
//
// All may be called from any context. The first two do not check that the quotient fits 16 bits; a
// divisor of 0 is forbidden for the same reason. The third one does, and takes every divisor.
#pragma once

#include <stdint.h>

// dividend = whole * divisor + rest, with rest < divisor.
struct quotient {
    // The quotient, rounded down.
    uint16_t whole;
    // What the division leaves over.
    uint16_t rest;
};

#if defined(__AVR__)

// value / divisor, rounded down. The quotient must have 16 bits: value >> 16 < divisor. 208 to 240
// cycles with the call (212 to 244 on the ATmega2560). divide.S.
uint16_t divide_u32_u16(uint32_t value, uint16_t divisor);

// (high << 16 | low) / divisor, where high < divisor. 200 to 232 cycles with the call (202 to 234).
// divide.S.
struct quotient divide_with_rest(uint16_t high, uint16_t low, uint16_t divisor);

// a * b / divisor, rounded down, and *rest, what the division leaves over. UINT32_MAX when the
// quotient has more than 32 bits or the divisor is 0; *rest then stays as it is. 1000 to 1288
// cycles with the call. divide.S.
uint32_t divide_product(uint32_t a, uint32_t b, uint32_t divisor, uint32_t *rest);

#else

// These functions in C: for every other compiler, and as the meaning of the assembly.
static inline uint16_t divide_u32_u16(uint32_t value, uint16_t divisor)
{
    return (uint16_t)(value / divisor);
}

static inline struct quotient divide_with_rest(uint16_t high,
                                               uint16_t low,
                                               uint16_t divisor)
{
    uint32_t value = ((uint32_t)high << 16) | low;

    return (struct quotient){(uint16_t)(value / divisor), (uint16_t)(value % divisor)};
}

static inline uint32_t divide_product(uint32_t a,
                                      uint32_t b,
                                      uint32_t divisor,
                                      uint32_t *rest)
{
    uint64_t product = (uint64_t)a * b;

    if (product >> 32 >= divisor) {
        return UINT32_MAX;
    }
    *rest = (uint32_t)(product % divisor);
    return (uint32_t)(product / divisor);
}

#endif
