// SPDX-License-Identifier: MIT
// Evenly spaced steps: step j of n in a piece of T ticks falls at ceil(j * T / n), the last one
// exactly at T. No multiplication and no division a step.
#pragma once

#include <stdint.h>

struct even {
    uint32_t base_ticks; // floor(T / n)
    uint16_t remainder;  // T mod n
    uint16_t steps;      // n
    uint16_t sum;        // carries the fraction, 0..n-1
};

// ticks: 1..2^24, steps: 1..32767. Divides once; not for an interrupt.
void even_start(struct even *even, uint32_t ticks, uint16_t steps);

// Pass over 1..n steps; the ticks to the last of them. Divides, but for n.
uint32_t even_skip(struct even *even, uint16_t steps);

// Ticks to the next step.
static inline uint32_t even_next(struct even *even)
{
    uint16_t sum = (uint16_t)(even->sum + even->remainder);
    uint32_t ticks = even->base_ticks;

    if (sum >= even->steps) {
        sum = (uint16_t)(sum - even->steps);
        ticks++;
    }
    even->sum = sum;
    return ticks;
}
