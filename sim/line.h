// SPDX-License-Identifier: MIT
// This file is MIT; the program it is linked into is GPL-3.0 as a whole, because of libsimavr.
//
// The serial line that the master and all boards share (RS-485, half duplex: nobody hears himself).
// A frame's whole course is known when it starts, a frame time before anyone has to act on it: that
// is what lets the boards run one after the other in quanta shorter than a frame.
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "uart.h"

#define LINE_BOARDS 4
#define LINE_MASTER (-1)
#define LINE_FRAMES 4096 // remembered; a power of two
#define LINE_CPU_HZ 16000000U
#define LINE_BAUD   115200U
#define LINE_BITS   11U   // of the master: 8 data bits, even parity, one stop bit
#define LINE_FORMAT 0x26U // the same in UCSR0C
#define LINE_SILENCE                                                                     \
    28000U // 1750 us: Modbus RTU's end of a frame at this speed, in cycles

struct line_frame {
    uint64_t start, end;
    uint32_t bit_cycles_x1000;
    int sender;
    uint8_t data;
    uint8_t format; // parity and data bits, as in UCSR0C
    bool corrupted; // by a collision, or cut off
};

struct line {
    struct uart *uart[LINE_BOARDS];
    int boards;
    struct line_frame frame[LINE_FRAMES];
    unsigned next_frame;

    uint64_t master_ready; // the master's transmitter is busy until this cycle
    uint32_t master_rest;  // fraction of that cycle, in units of 1 / LINE_BAUD
    unsigned heard;        // index of the next frame the master looks at
    uint64_t corrupted_frames;
};

void line_init(struct line *line);

// Puts a frame on the line and tells everyone else; collisions spoil both.
struct line_frame *line_start(struct line *line, const struct line_frame *frame);

// The master sends bytes back to back (115200 8E1), not before `cycle`. Returns the end of the
// last.
uint64_t line_master_send(struct line *line,
                          const uint8_t *bytes,
                          size_t count,
                          uint64_t cycle);

// The next byte that the master has received up to this cycle, or -1. *end is the end of its frame.
int line_master_receive(struct line *line, uint64_t cycle, uint64_t *end);

// True while a board's frame is on its way at this cycle.
bool line_busy(const struct line *line, uint64_t cycle);
