// SPDX-License-Identifier: MIT
// Quotients for which the code of avr-gcc needs three times as long. The AVR has them in assembly;
// every other compiler gets the C below, which is also what the assembly means. The checks of
// lines, the decoders of steps and the setting of a period divide by these functions.
//
//     function              dividend    divisor    result
//     divide_u32_u16()      32 bits     16 bits    quotient, 16 bits
//     divide_with_rest()    2 x 16      16 bits    quotient and rest, 16 bits each
//     divide_product()      32 x 32     32 bits    quotient and rest, 32 bits each
//
// The functions have no state and may be called from any context. The first two do not check that
// the quotient fits 16 bits: where the quotient does not fit, or the divisor is 0, the result means
// nothing. divide_product() checks both.
#pragma once

#include <stdint.h>

// dividend = whole * divisor + rest, with rest < divisor.
struct quotient {
    // The quotient, rounded down, 0..65535.
    uint16_t whole;
    // What the division leaves over, 0..divisor-1.
    uint16_t rest;
};

#if defined(__AVR__)

// value / divisor, rounded down. The quotient must have 16 bits: value >> 16 < divisor. 208 to 240
// cycles with the call (212 to 244 on the ATmega2560). divide.S.
uint16_t divide_u32_u16(uint32_t value, uint16_t divisor);

// (high << 16 | low) / divisor, where high < divisor. 200 to 232 cycles with the call (202 to 234).
// divide.S.
struct quotient divide_with_rest(uint16_t high, uint16_t low, uint16_t divisor);

// a * b / divisor, rounded down; the product may have 64 bits. *rest gets what the division leaves
// over, 0..divisor-1. Returns UINT32_MAX and leaves *rest as it is when the quotient has more than
// 32 bits or the divisor is 0. 1000 to 1288 cycles with the call: for settings and starts of lines,
// not for steps. divide.S.
uint32_t divide_product(uint32_t a, uint32_t b, uint32_t divisor, uint32_t *rest);

#else

// The same functions in C, for every other compiler.

// value / divisor. The cast drops what a quotient has above 16 bits.
static inline uint16_t divide_u32_u16(uint32_t value, uint16_t divisor)
{
    return (uint16_t)(value / divisor);
}

// (high << 16 | low) / divisor and its rest.
static inline struct quotient divide_with_rest(uint16_t high,
                                               uint16_t low,
                                               uint16_t divisor)
{
    uint32_t value = ((uint32_t)high << 16) | low;

    return (struct quotient){(uint16_t)(value / divisor), (uint16_t)(value % divisor)};
}

// a * b / divisor and its rest. The comparison of the upper half also refuses a divisor of 0,
// because no number is below 0.
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
