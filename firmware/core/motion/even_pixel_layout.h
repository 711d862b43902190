// SPDX-License-Identifier: MIT
// Where the assembly (even_pixel_put.S) finds the members of struct even_pixel, struct stream and
// struct stream_mark; checked in even_pixel.c. The assembler reads this file, too: plain numbers
// only.
//
// Offsets and sizes in bytes.
#pragma once

// struct even_pixel.
#define EVEN_PIXEL_TICKS     0
#define EVEN_PIXEL_BASE      2
#define EVEN_PIXEL_STEPS     4
#define EVEN_PIXEL_REMAINDER 5

// struct stream.
#define EVEN_PIXEL_RING           0
#define EVEN_PIXEL_HEAD           4
#define EVEN_PIXEL_MARK_HEAD      7
#define EVEN_PIXEL_MARK_PLACED    8
#define EVEN_PIXEL_BEHIND_PERIODS 10
#define EVEN_PIXEL_BEHIND_TICKS   11
#define EVEN_PIXEL_END_TICKS      13
#define EVEN_PIXEL_MARKS          33
#define EVEN_PIXEL_MARK_COUNT     16

// struct stream_mark.
#define EVEN_PIXEL_MARK_SLOT     0
#define EVEN_PIXEL_MARK_FLAGS    1
#define EVEN_PIXEL_MARK_PERIODS  2
#define EVEN_PIXEL_MARK_POSITION 3
#define EVEN_PIXEL_MARK_TICKS    5
#define EVEN_PIXEL_MARK_BYTES    7
