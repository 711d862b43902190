// SPDX-License-Identifier: MIT
// Pixels of few evenly spaced steps: the common case where the pixel clock runs at kilohertz. Such
// a pixel is written into the stream as a whole, one entry a step, with the very intervals that
// even.h makes, at a cost that a pixel of a few hundred microseconds leaves room for. Main loop
// only.
//
//     T = 10, n = 4     base 2, remainder 2     entries   3  2  3  2
//
// What the last pixel knew is kept (even_rate.h): a pixel of as many steps needs no quotient,
// whatever a tick or two of difference in its length. Boards of several axes keep the last quotient
// of each small number of steps. Any other quotient comes from a table of reciprocals.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "build_features.h" // SEVERAL_AXES
#include "stream/stream.h"  // struct stream

struct line;
struct even_rate;

// Most steps of such a pixel. More are worth a pulse train.
#define EVEN_PIXEL_MAX_STEPS 120u
// Shortest interval of such a pixel, ticks. A pulse train may follow, and the step interrupt needs
// this long to begin one behind a single period.
#define EVEN_PIXEL_MIN_TICKS 128u

// Longest interval of such a pixel, ticks, with room for a longer one beside it.
#define EVEN_PIXEL_MAX_INTERVAL 0xFBFFu
// Longest such pixel, ticks: some 60 Hz. A longer pixel may cost more.
#define EVEN_PIXEL_MAX_TICKS 0x3FFFFuL

// What one pixel costs of a round's budget, besides a quarter of its steps.
#define EVEN_PIXEL_COST 10u

// Write the line's next pixels as long as each is one of few even steps in the direction of the
// steps before it, and as budget, ring and waypoints allow. Returns what they cost of a round's
// budget; 0: the next one is something else, EVEN_PIXEL_WAITS: it has no room now. Only when the
// newest step lies at the line's place, its period is still to be written, and one waypoint waits
// for that period.
uint8_t even_pixels_write(struct line *line,
                          struct stream *stream,
                          bool negative,
                          uint8_t budget);

// Result of even_pixels_write(): the ring or the waypoints have no room for the next pixel.
#define EVEN_PIXEL_WAITS 0xFFu

// The interval of a pixel of this many steps and ticks. Returns false when the intervals are too
// short or too long for single periods. For even_pixels_write() only, which is assembly on a board.
bool even_pixel_divide(struct even_rate *rate, uint8_t steps, uint32_t ticks);

#if SEVERAL_AXES
// floor(65536 / n) of a number of steps n, in flash; 65535 for n = 1. For even_pixel.c and its
// assembly only.
extern const uint16_t even_pixel_reciprocals[EVEN_PIXEL_MAX_STEPS + 1u];
#endif
