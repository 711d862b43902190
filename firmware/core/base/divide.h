// SPDX-License-Identifier: MIT
// Quotients for which avr-gcc needs three times as long: assembly there. The C that the assembly
// stands for is beside it; every other compiler gets the C.
#pragma once

#include <stdint.h>

struct quotient {
    uint16_t whole;
    uint16_t rest;
};

#if defined(__AVR__)

// value / divisor, which must have 16 bits: value >> 16 < divisor. 208 to 240 cycles with the call
// (212 to 244 on the ATmega2560). divide.S.
uint16_t divide_u32_u16(uint32_t value, uint16_t divisor);

// (high << 16 | low) / divisor, where high < divisor. 200 to 232 cycles with the call (202 to 234).
// divide.S.
struct quotient divide_with_rest(uint16_t high, uint16_t low, uint16_t divisor);

#else

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

#endif
