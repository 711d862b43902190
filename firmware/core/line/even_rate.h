// SPDX-License-Identifier: MIT
// What a line keeps of its last pixel of few even steps, so that the next one, which is often as
// long to a tick or two, needs no division. A header of its own, because such pixels (even_pixel.h)
// are made from a line, and the line holds this. even_pixel.c and its assembly write it. Main loop
// only.
#pragma once

#include <stdint.h>

// The interval of the last such pixel of the line: ticks = base_ticks * steps + remainder.
struct even_rate {
    // Length of the pixel, ticks, modulo 2^16: the pixels of a line differ by less.
    uint16_t ticks;
    // Shorter interval, ticks.
    uint16_t base_ticks;
    // Number of steps, 1..EVEN_PIXEL_MAX_STEPS; 0: there was no such pixel yet, or its interval did
    // not fit. line_begin() sets 0.
    uint8_t steps;
    // How many of the intervals are one tick longer, 0..steps-1.
    uint8_t remainder;
};
