// SPDX-License-Identifier: MIT
#include "motion/even.h"

void even_start(struct even *even, uint32_t ticks, uint16_t steps)
{
    even->base_ticks = ticks / steps;
    even->remainder = (uint16_t)(ticks - even->base_ticks * steps);
    even->steps = steps;
    // Starting at n - 1 instead of 0 turns the floor of the accumulated fraction into its ceiling.
    even->sum = (uint16_t)(steps - 1u);
}

uint32_t even_skip(struct even *even, uint16_t steps)
{
    // All steps of the piece together need no division.
    if (steps == even->steps) {
        return steps * even->base_ticks + even->remainder;
    }
    uint32_t fraction = (uint32_t)steps * even->remainder + even->sum;
    uint32_t whole = fraction / even->steps;

    even->sum = (uint16_t)(fraction - whole * even->steps);
    return steps * even->base_ticks + whole;
}
