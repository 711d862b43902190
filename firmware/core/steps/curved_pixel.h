// SPDX-License-Identifier: MIT
// Pixels of few steps under constant acceleration: a smooth line's ramps where the pixel clock runs
// fast or the steps are slow. Such a pixel is written into the stream as a whole, like one of even
// steps (even_pixel.h), at a fraction of what a piece of any kind costs. The ticks of its steps are
// those of curve_steep.h. Main loop only.
//
//     speeds     4           6           8          steps/pixel at the pixels' edges
//     pixels     |     5     |     7     |          the extrapolation of intervals goes on from
//     h                1           1                pixel to pixel while h stays the same
#pragma once

#include <stdint.h>

#include "line/line.h"         // struct line
#include "steps/curve_steep.h" // struct curve_steep
#include "stream/stream.h"     // struct stream

// Most steps of such a pixel. More are worth a piece of their own. The shortest interval is that of
// even pixels.
#define CURVED_PIXEL_MAX_STEPS 64u

// Write the line's next pixel if it is one of few steps under acceleration, and a waypoint at its
// end. Returns what the pixel costs of a round's budget, 1..120. Returns 0 if the next pixel is
// something else or no waypoint is free: nothing was written. Returns EVEN_PIXEL_WAITS if the ring
// has no room for the pixel.
//
// steep: the last intervals of such pixels of the axis; between two of these pixels nobody else may
// write *steep while line->curve_half is not 0. Only when even_pixels_write() may be called and has
// found another pixel, and when the pixel has its length (line_is_early() is false). Divides.
uint8_t curved_pixel_write(struct line *line,
                           struct curve_steep *steep,
                           struct stream *stream);
