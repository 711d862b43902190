// SPDX-License-Identifier: MIT Pixels of few evenly spaced steps: the common case where the pixel
// clock runs at kilohertz. Such a pixel is written into the stream as a whole, one entry a step,
// with the very intervals that even.h makes, at a cost that a pixel of a few hundred microseconds
// leaves room for. Main loop only.
//
//     T = 10, n = 4     base 2, remainder 2     entries   3  2  3  2
//
// What the last pixel knew is kept: a pixel of as many steps needs no quotient, whatever a tick or
// two of difference in its length. Any other takes its quotient from a table of reciprocals.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "motion/stream.h" // struct stream

struct line;

// Most steps of such a pixel. More are worth a pulse train.
#define EVEN_PIXEL_MAX_STEPS 64u
// Shortest interval of such a pixel, ticks. A pulse train may follow, and the step interrupt needs
// this long to begin one behind a single period.
#define EVEN_PIXEL_MIN_TICKS 128u

// Longest such pixel, ticks: some 60 Hz. A longer one may cost more.
#define EVEN_PIXEL_MAX_TICKS 0x3FFFFuL

// The interval of the last such pixel of the line: ticks = base_ticks * steps + remainder.
struct even_pixel {
    // Length of the pixel, modulo 2^16: the pixels of a line differ by less.
    uint16_t ticks;
    // Shorter interval, ticks.
    uint16_t base_ticks;
    // Number of steps; 0: there was no such pixel yet. To be set at the start of a line.
    uint8_t steps;
    // So many intervals are one tick longer, 0..steps-1.
    uint8_t remainder;
};

// Write the line's next pixels as long as each is one of few even steps in the direction of the
// steps before it, and as budget, ring and marks allow. Returns what they cost of a round's budget;
// 0: the next one is something else, EVEN_PIXEL_WAITS: it has no room now. Only when the newest
// step lies at the line's place, its period is still to be written, and one mark waits for that
// period.
uint8_t even_pixels_write(struct line *line,
                          struct stream *stream,
                          bool negative,
                          uint8_t budget);

// Result of even_pixels_write(): the ring has no room for the next pixel.
#define EVEN_PIXEL_WAITS 0xFFu
