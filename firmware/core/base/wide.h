// SPDX-License-Identifier: MIT
// Two's complement numbers of 40 bits, for a processor on which 64 bits cost much more. The curves
// (steps/) keep their places in such numbers. Nothing reports that a sum leaves the range: the
// users of the numbers say why a sum stays inside the range, or why only its value modulo 2^40
// counts.
//
//     range    -2^39 .. 2^39 - 1; sums and products wrap at 2^40
//
//     wide_from(), wide_from_int32()    into a wide number
//     wide_to()                         back to 64 bits
//     wide_add(), wide_sub()            a + b, a - b           in assembly on the AVR
//     wide_times()                      a * factor             in assembly on the AVR
//
// Every function is pure and may be called from any context.
#pragma once

#include <stdint.h>

#include "base/multiply.h" // multiply_u32_u16

// The value is high * 256 + low.
//
//     byte      0     1     2     3     4
//     member   |high, lowest first     |low|
//     weight    2^8   2^16  2^24  2^32  2^0
struct wide {
    // The upper four bytes carry the sign.
    int32_t high;
    // The lowest byte, 0..255 also of a negative number.
    uint8_t low;
};

// The lower 40 bits of a number of 64 bits.
static inline struct wide wide_from(int64_t value)
{
    return (struct wide){.high = (int32_t)(value >> 8), .low = (uint8_t)value};
}

// A number of 32 bits, exactly.
static inline struct wide wide_from_int32(int32_t value)
{
    return (struct wide){.high = value >> 8, .low = (uint8_t)value};
}

// The number with 64 bits, exactly. For tests and for processors that have them.
static inline int64_t wide_to(struct wide value)
{
    return (int64_t)value.high * 256 + value.low;
}

#if defined(__AVR__)

// a + b modulo 2^40, like the C below. 5 cycles, and what moving the operands takes.
static inline struct wide wide_add(struct wide a, struct wide b)
{
    __asm__("add %0, %2\n\t"
            "adc %A1, %A3\n\t"
            "adc %B1, %B3\n\t"
            "adc %C1, %C3\n\t"
            "adc %D1, %D3\n\t"
            : "+&r"(a.low), "+r"(a.high)
            : "r"(b.low), "r"(b.high));
    return a;
}

// a - b modulo 2^40, like the C below, at the cost of wide_add().
static inline struct wide wide_sub(struct wide a, struct wide b)
{
    __asm__("sub %0, %2\n\t"
            "sbc %A1, %A3\n\t"
            "sbc %B1, %B3\n\t"
            "sbc %C1, %C3\n\t"
            "sbc %D1, %D3\n\t"
            : "+&r"(a.low), "+r"(a.high)
            : "r"(b.low), "r"(b.high));
    return a;
}

// a * factor modulo 2^40; `a` has a sign, the factor (0..65535) has none. 51 cycles with the call
// (53 on the ATmega2560). The call is made in assembly for the reason that base/multiply.h gives.
static inline __attribute__((always_inline)) struct wide wide_times(struct wide a,
                                                                    uint16_t factor)
{
    __asm__("" : "+r"(a.low), "+r"(factor));
    register int32_t high __asm__("r20") = a.high;
    register uint16_t by __asm__("r18") = factor;
    register uint8_t low __asm__("r24") = a.low;
    register int32_t product_high __asm__("r18");
    register uint8_t product_low __asm__("r22");

    __asm__("%~call wide_times_in_registers" // wide.S
            : "=r"(product_high), "=r"(product_low)
            : "r"(by), "r"(high), "r"(low)
            : "r25", "r26", "r27", "r30", "r31");
    return (struct wide){.high = product_high, .low = product_low};
}

#else

// The same functions in C. Everything is modulo 2^40 on purpose. C leaves the overflow of a signed
// sum undefined, so that the sums are made of unsigned numbers.

// a + b modulo 2^40: the carry out of the lowest byte goes into the sum of the upper four.
static inline struct wide wide_add(struct wide a, struct wide b)
{
    uint16_t low = (uint16_t)((uint16_t)a.low + b.low);
    uint32_t high = (uint32_t)a.high + (uint32_t)b.high + (uint32_t)(low >> 8);

    return (struct wide){.high = (int32_t)high, .low = (uint8_t)low};
}

// a - b modulo 2^40: the upper four bytes lose one where the lowest byte has to borrow.
static inline struct wide wide_sub(struct wide a, struct wide b)
{
    uint32_t high = (uint32_t)a.high - (uint32_t)b.high - (a.low < b.low ? 1u : 0u);

    return (struct wide){.high = (int32_t)high, .low = (uint8_t)(a.low - b.low)};
}

// a * factor modulo 2^40: what the lowest byte's product has above 8 bits goes into the upper four.
static inline struct wide wide_times(struct wide a, uint16_t factor)
{
    uint32_t low = (uint32_t)a.low * factor;
    uint32_t high = multiply_u32_u16((uint32_t)a.high, factor) + (low >> 8);

    return (struct wide){.high = (int32_t)high, .low = (uint8_t)low};
}

#endif
