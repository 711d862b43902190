// SPDX-License-Identifier: MIT
// A quotient that avr-gcc takes three times as long for, hand coded there.
#pragma once

#include <stdint.h>

struct quotient {
    uint16_t whole;
    uint16_t rest;
};

#if defined(__AVR__)

// value / divisor where that has 16 bits: value >> 16 < divisor. 200 cycles. divide.S.
uint16_t divide_u32_u16(uint32_t value, uint16_t divisor);

// (high << 16 | low) / divisor, high below the divisor. divide.S.
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
