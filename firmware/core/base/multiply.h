// SPDX-License-Identifier: MIT
// Products for which avr-gcc generates slow code: assembly there. The C that the assembly stands
// for is beside it; every other compiler gets the C.
#pragma once

#include <stdint.h>

#if defined(__AVR__)

// (uint32_t)((int32_t)a * b), for both signs of each. 19 cycles.
static inline uint32_t multiply_s16_s16(int16_t a, int16_t b)
{
    uint32_t product;

    __asm__("mul %A1, %A2\n\t" // low * low
            "movw %A0, r0\n\t"
            "muls %B1, %B2\n\t" // high * high, both signed
            "movw %C0, r0\n\t"
            "mulsu %B1, %A2\n\t" // high of a, signed, * low of b
            "sbc %D0, %3\n\t"    // the carry of mulsu is the sign of its product
            "add %B0, r0\n\t"
            "adc %C0, r1\n\t"
            "adc %D0, %3\n\t"
            "mulsu %B2, %A1\n\t"
            "sbc %D0, %3\n\t"
            "add %B0, r0\n\t"
            "adc %C0, r1\n\t"
            "adc %D0, %3\n\t"
            "clr r1\n\t"
            : "=&r"(product)
            : "a"(a), "a"(b), "r"((uint8_t)0));
    return product;
}

// a * b modulo 2^32. 38 cycles with the call (40 on the ATmega2560). multiply.S.
uint32_t multiply_u32_u16(uint32_t a, uint16_t b);

#else

static inline uint32_t multiply_s16_s16(int16_t a, int16_t b)
{
    return (uint32_t)((int32_t)a * b);
}

static inline uint32_t multiply_u32_u16(uint32_t a, uint16_t b)
{
    return a * b;
}

#endif
