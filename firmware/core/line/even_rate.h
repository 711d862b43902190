// SPDX-License-Identifier: MIT
// What a line keeps of its last pixel of few even steps. A header of its own, because such pixels
// (even_pixel.h) are made from a line, and the line holds this.
#pragma once

#include <stdint.h>

// The interval of the last such pixel of the line: ticks = base_ticks * steps + remainder.
struct even_rate {
    // Length of the pixel, modulo 2^16: the pixels of a line differ by less.
    uint16_t ticks;
    // Shorter interval, ticks.
    uint16_t base_ticks;
    // Number of steps; 0: there was no such pixel yet. To be set at the start of a line.
    uint8_t steps;
    // So many intervals are one tick longer, 0..steps-1.
    uint8_t remainder;
};
