// SPDX-License-Identifier: MIT
// Pixels of few evenly spaced steps: the common case where the pixel clock runs at kilohertz. Such
// a pixel is written into the stream as a whole, one entry a step, with the very intervals that
// even.h makes, at a cost that a pixel of a few hundred microseconds leaves room for. Main loop
// only.
//
//     T = 10, n = 4     base 2, remainder 2     entries   3  2  3  2
//
// The interval of the last pixel is kept (even_rate.h): a pixel of as many steps whose length
// differs by a tick or two needs no quotient. Boards of several axes also keep the last quotients
// of several numbers of steps; for a pixel below 2^16 ticks they take any other quotient from a
// table of reciprocals. All else is a division.
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
// this long to begin a train after a single period.
#define EVEN_PIXEL_MIN_TICKS 128u

// Longest shorter interval of such a pixel, ticks: the longer one, a tick more, is a single period
// too.
#define EVEN_PIXEL_MAX_INTERVAL 0xFBFFu
// Longest such pixel, ticks, that is a clock of some 60 Hz. A longer pixel has time enough to be
// made by way of a piece.
#define EVEN_PIXEL_MAX_TICKS 0x3FFFFuL

// What one pixel costs of a round's budget, besides a quarter of its steps.
#define EVEN_PIXEL_COST 10u

// Write the line's next pixels as long as each is one of few even steps in the direction of the
// steps before it, and as budget, ring and waypoints allow; each pixel with a waypoint at its end.
// budget: 1..255; the last pixel may cost more than is left. Returns what the pixels cost of a
// round's budget. With no pixel written it returns 0 if the next one is something else or must wait
// for the clock, and EVEN_PIXEL_WAITS if the next one has no room now: line->room then tells how
// much room in the ring it needs, if the ring is what is full.
//
// Only when the newest step lies at the line's place, its period is still to be written, exactly
// one waypoint waits for that period, and line_on_pixels() is true. negative: direction of the
// newest step.
uint8_t even_pixels_write(struct line *line,
                          struct stream *stream,
                          bool negative,
                          uint8_t budget);

// Result of even_pixels_write(): the ring or the waypoints have no room for the next pixel.
#define EVEN_PIXEL_WAITS 0xFFu

// Set *rate to the interval of a pixel. steps: 1..EVEN_PIXEL_MAX_STEPS; ticks: length of the pixel,
// up to EVEN_PIXEL_MAX_TICKS. Returns false when the intervals are too short or too long for single
// periods; *rate then has no interval that a later pixel would take over. For even_pixels_write()
// only, which is assembly on a board.
bool even_pixel_divide(struct even_rate *rate, uint8_t steps, uint32_t ticks);

#if SEVERAL_AXES
// floor(65536 / n) by number of steps n, in flash; 65535 for n = 1, and element 0 means nothing.
// For even_pixel.c and its assembly only.
extern const uint16_t even_pixel_reciprocals[EVEN_PIXEL_MAX_STEPS + 1u];
#endif
