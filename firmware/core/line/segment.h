// SPDX-License-Identifier: MIT
// How a line is stored and sent: as segments and marks, 4 bytes each. A segment is `repeat` equal
// pixels of `count` steps each. An entry with repeat 0 is a mark, and its count is the mark's word.
// A start mark is followed by one parameter entry. The host sends lines so; the check, the queue
// and segment_source.c read them.
//
//     start      (word, 0) (backlash_steps, line_speed)    word: kind and flags, see below
//     divider    (M, 0), only with LINE_START_DIVIDER: a pixel of this line is M clock edges
//     segments   (count, repeat) ...
//     end        (LINE_MARK_END, 0)
//
// A seek is a line that ends early, when the axis's home switch closes or opens. Its segments
// accelerate and then hold the speed; the segments after the down mark mirror the acceleration.
// When the switch trips, the seek finishes the current pixel and continues with the first segment
// after the down mark whose count is below the current speed. The current speed of a plain line is
// the count of its last pixel; of a smooth line, the speed at the end of its last pixel.
//
//     (1, 1) (2, 1) (4, 1) (8, 900)  (LINE_MARK_DOWN, 0)  (4, 1) (2, 1) (1, 1)
//                   ^ trips here: one pixel of 4, then ----------^
#pragma once

#include <stdint.h>

// Bits of a mark's word that say which mark it is.
#define LINE_MARK_KIND  0x000Fu
#define LINE_MARK_START 0x0001u
#define LINE_MARK_END   0x0002u
#define LINE_MARK_DOWN  0x0003u
// Flags of a start mark.
//
// Constant acceleration inside a pixel; without the flag, constant speed inside a pixel.
#define LINE_START_SMOOTH 0x0010u
// Line zero is one pixel period after a pixel clock edge; without the flag, the line follows the
// line before it without a gap.
#define LINE_START_WAIT 0x0020u
// A smooth line that moves in negative direction; a plain line's counts have signs instead.
#define LINE_START_NEGATIVE 0x0040u
// A seek: the line moves until the home switch closes,
#define LINE_START_SEEK 0x0080u
// or, together with LINE_START_SEEK, until the home switch opens.
#define LINE_START_OPEN 0x0100u
// A third entry, (M, 0), follows the parameter: a pixel of the line is M clock edges. Setting
// `divider` becomes M if it is another number (app/registers/data.c).
#define LINE_START_DIVIDER 0x0200u
// Another line follows without a gap. Of the axes whose lines say so, none begins its next line
// unless all of them have theirs (axis_line_decoded()). A board of one axis ignores the flag.
#define LINE_START_MORE 0x0400u
// All flags of a start mark.
#define LINE_START_FLAGS 0x07F0u
// The flags of a start mark's low byte that a check keeps; struct line_check has them at the same
// bits.
#define LINE_START_KEPT (LINE_START_SMOOTH | LINE_START_NEGATIVE | LINE_START_SEEK)
// Entries in front of a line's segments, without the divider. Those entries and the divider are
// always stored in full (segment_pack.h).
#define LINE_HEAD_ENTRIES 2u

// An entry of a line: a segment, a mark or a parameter.
struct segment {
    // Steps in each pixel, -16383..16383 in plain lines and 0..16383 in smooth ones. Of a mark: its
    // word.
    int16_t count;
    // Number of pixels; 0 makes the entry a mark.
    uint16_t repeat;
};
