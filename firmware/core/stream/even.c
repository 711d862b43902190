// SPDX-License-Identifier: MIT
#include "stream/even.h"

#include <stdbool.h>

#include "base/apart.h"     // APART
#include "base/divide.h"    // divide_with_rest
#include "base/multiply.h"  // multiply_u32_u16
#include "build_features.h" // SEVERAL_AXES

// True when the quotient and the remainder that stand there, of whatever piece, are those of
// ticks / steps. Quotients of 16 bits: no product wraps.
static bool is_divided(const struct even *even, uint32_t ticks, uint16_t steps)
{
    return even->base_ticks >> 16 == 0 && even->remainder < steps &&
           multiply_u32_u16(even->base_ticks, steps) + even->remainder == ticks;
}

void even_start(struct even *even, uint32_t ticks, uint16_t steps)
{
    // Pixels of a constant speed are alike, and a product costs a tenth of a division.
    if (!SEVERAL_AXES || !is_divided(even, ticks, steps)) {
        even->base_ticks = ticks / steps;
        even->remainder = (uint16_t)(ticks % steps);
    }
    even->steps = steps;
    // Starting at n - 1 instead of 0 turns the floor of the accumulated fraction into its ceiling.
    even->sum = (uint16_t)(steps - 1u);
}

APART uint32_t even_skip(struct even *even, uint16_t steps)
{
    BY_POINTER_SMALL(even);
    // All steps of the piece together need no division.
    if (steps == even->steps) {
        return multiply_u32_u16(even->base_ticks, steps) + even->remainder;
    }
    // Below n * n, since neither the remainder nor the sum reaches n.
    uint32_t fraction = multiply_u32_u16(even->remainder, steps) + even->sum;
    struct quotient whole =
        divide_with_rest((uint16_t)(fraction >> 16), (uint16_t)fraction, even->steps);

    even->sum = whole.rest;
    return multiply_u32_u16(even->base_ticks, steps) + whole.whole;
}
