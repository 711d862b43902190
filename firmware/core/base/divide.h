// SPDX-License-Identifier: MIT
// A quotient that avr-gcc takes three times as long for, hand coded there.
#pragma once

#include <stdint.h>

#if defined(__AVR__)

// value / divisor where that has 16 bits: value >> 16 < divisor. 200 cycles. divide.S.
uint16_t divide_u32_u16(uint32_t value, uint16_t divisor);

// The same, with what is left of value in the upper 16 bits.
uint32_t divide_with_rest(uint32_t value, uint16_t divisor);

#else

static inline uint16_t divide_u32_u16(uint32_t value, uint16_t divisor)
{
    return (uint16_t)(value / divisor);
}

static inline uint32_t divide_with_rest(uint32_t value, uint16_t divisor)
{
    return (value % divisor << 16) | (uint16_t)(value / divisor);
}

#endif
