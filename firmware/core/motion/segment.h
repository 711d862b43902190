// SPDX-License-Identifier: MIT
// How a line travels and waits: as runs and marks. A run is `repeat` pixels of `count` steps each.
// An entry with repeat 0 is a mark, its count a mark word; a start mark is followed by one
// parameter entry.
//
//     start   (word, 0) (backlash_steps, line_speed)    word: kind, flags below
//     runs    (count, repeat) ...
//     end     (LINE_MARK_END, 0)
//
// A seek is a line that ends early when the axis's home switch is as sought. Its runs speed up and
// hold; those behind a down mark mirror the way up. From wherever it trips, it goes on with the
// first run behind the mark whose count is below its speed: that of the last pixel in a plain line,
// that at the end of the last pixel in a smooth one.
//
//     (1, 1) (2, 1) (4, 1) (8, 900)  (LINE_MARK_DOWN, 0)  (4, 1) (2, 1) (1, 1)
//                   ^ trips here: one pixel of 4, then ---------^
#pragma once

#include <stdint.h>

#define LINE_MARK_KIND  0x000Fu
#define LINE_MARK_START 0x0001u
#define LINE_MARK_END   0x0002u
#define LINE_MARK_DOWN  0x0003u
#define LINE_START_SMOOTH                                                                \
    0x0010u // constant acceleration inside a pixel; else constant speed
#define LINE_START_WAIT                                                                  \
    0x0020u // zero is one period after a pixel clock edge; else chained
#define LINE_START_NEGATIVE 0x0040u // a smooth line that runs in negative direction
#define LINE_START_SEEK     0x0080u // until the home switch closes,
#define LINE_START_OPEN     0x0100u //   or, together with it, opens
#define LINE_START_KNOWN    0x01D1u // bits of a start mark that have a meaning, less WAIT

struct segment {
    int16_t count;   // steps in each pixel, signed for plain lines
    uint16_t repeat; // pixels; 0 makes the entry a mark
};
