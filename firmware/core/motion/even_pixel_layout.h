// SPDX-License-Identifier: MIT
// Where the assembly (even_pixel*.S, ledger_pixels.S) finds the members of struct even_rate, struct
// line, struct stream and struct stream_mark; checked in even_pixel.c. The assembler reads this
// file, too: plain numbers only.
//
// Offsets and sizes in bytes.
#pragma once

// struct even_rate.
#define EVEN_PIXEL_TICKS     0
#define EVEN_PIXEL_BASE      2
#define EVEN_PIXEL_STEPS     4
#define EVEN_PIXEL_REMAINDER 5

// struct stream.
#define EVEN_PIXEL_RING        0
#define EVEN_PIXEL_HEAD        4
#define EVEN_PIXEL_RETIRED     5
#define EVEN_PIXEL_MARK_HEAD   7
#define EVEN_PIXEL_MARK_PLACED 8
#define EVEN_PIXEL_MARK_TAIL   9
#define EVEN_PIXEL_MARK_COUNT  16

// struct stream_mark.
#define EVEN_PIXEL_MARK_SLOT     0
#define EVEN_PIXEL_MARK_PERIODS  1
#define EVEN_PIXEL_MARK_POSITION 2

// What tells the reader the length of whole pixels.
#define EVEN_PIXEL_BEHIND_PERIODS 10
#define EVEN_PIXEL_BEHIND_TICKS   11
#define EVEN_PIXEL_END_TICKS      13
#define EVEN_PIXEL_MARKS          33
#define EVEN_PIXEL_MARK_TICKS     4
#define EVEN_PIXEL_MARK_BYTES     6

// Its batches, the reader's end behind the writer's.
#define EVEN_PIXEL_BATCH_HEAD 129

// struct line. Its queue is at its beginning.
#define EVEN_PIXEL_COUNT      2
#define EVEN_PIXEL_REPEAT     4
#define EVEN_PIXEL_RATE       7
#define EVEN_PIXEL_CURVE_HALF 13
#define EVEN_PIXEL_SPEED      19
#define EVEN_PIXEL_POSITION   21
#define EVEN_PIXEL_TO_EDGE    23
#define EVEN_PIXEL_ROOM       27

// struct segment_queue, and the first bytes of packed entries.
#define EVEN_PIXEL_QUEUE_BYTES 0
#define EVEN_PIXEL_QUEUE_MASK  2
#define EVEN_PIXEL_QUEUE_AT    4
#define EVEN_PIXEL_QUEUE_LAST  6
#define EVEN_PIXEL_QUEUE_HEAD  8
#define EVEN_PIXEL_NEAR_ZERO   0x38
#define EVEN_PIXEL_NEAR_LAST   0x70
#define EVEN_PIXEL_SHORT_RUN   0x6F
#define EVEN_PIXEL_RUN         0x77

// The line's flags, and the bits of smooth and edge_open among them.
#define EVEN_PIXEL_FLAGS         6
#define EVEN_PIXEL_SMOOTH_BIT    0
#define EVEN_PIXEL_EDGE_OPEN     0x80
#define EVEN_PIXEL_EDGE_OPEN_BIT 7

// Its walk along the pixel edges: mode 0 is the exact grid.
#define EVEN_PIXEL_GRID_MODE 28
#define EVEN_PIXEL_GRID      31

// Limits: even_pixel.h, stream.h and step_ring.h have the names.
#define EVEN_PIXEL_MOST_STEPS    120
#define EVEN_PIXEL_BASE_MIN      128  /* shortest interval, */
#define EVEN_PIXEL_BASE_MAX_HIGH 0xFC /* and the high byte of one that is too long */
#define EVEN_PIXEL_TICKS_TOO_BIG 4    /* third byte */
#define EVEN_PIXEL_COST          10
#define EVEN_PIXEL_RING_CAPACITY 252
