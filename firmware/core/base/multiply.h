// SPDX-License-Identifier: MIT
// A product for which avr-gcc generates slow code. The AVR has it in assembly; every other compiler
// gets the C below, which is also what the assembly means. The product of 32 by 16 bits is all that
// the decoders, the account and the pixel clock's filter need. The function has no state and may be
// called from any context.
#pragma once

#include <stdint.h>

#if defined(__AVR__)

// a * b modulo 2^32. 38 cycles with the call (40 on the ATmega2560).
//
// The call is made in assembly, so that the compiler keeps values in the registers that the product
// leaves alone: a call of a C function would cost all of those registers. To compute an argument
// may itself take a call, which changes registers that were assigned before. The empty assembly
// therefore has b computed before the first register is assigned.
static inline __attribute__((always_inline)) uint32_t multiply_u32_u16(uint32_t a,
                                                                       uint16_t b)
{
    __asm__("" : "+r"(b));
    register uint32_t product __asm__("r22") = a;
    register uint16_t factor __asm__("r20") = b;

    __asm__("%~call multiply_in_registers" // multiply.S
            : "+r"(product)
            : "r"(factor)
            : "r18", "r26", "r27", "r30", "r31");
    return product;
}

#else

// The function in C. The product wraps at 2^32, as in the assembly.
static inline uint32_t multiply_u32_u16(uint32_t a, uint16_t b)
{
    return a * b;
}

#endif
