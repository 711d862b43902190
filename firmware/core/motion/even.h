// SPDX-License-Identifier: MIT
// Evenly spaced steps: step j of n in a piece of T ticks falls at ceil(j * T / n), the last one
// exactly at T. A step takes no multiplication and no division. Main loop only.
#pragma once

#include <stdint.h>

struct even {
    // Shorter interval: floor(T / n), ticks.
    uint32_t base_ticks;
    // T mod n: so many of the n intervals are one tick longer.
    uint16_t remainder;
    // n
    uint16_t steps;
    // The fraction carried from step to step, 0..n-1.
    uint16_t sum;
};

// Begin a piece. ticks: 1..2^24, steps: 1..32767. Divides once.
void even_start(struct even *even, uint32_t ticks, uint16_t steps);

// Pass over 1..n steps. Returns the ticks to the last of them. Divides, except for n steps at once.
uint32_t even_skip(struct even *even, uint16_t steps);

// Ticks from the last step to the next one.
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
