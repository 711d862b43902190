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

#include "cpu_clock.h"
#include "uart.h"
#include "wire_log.h"

#define LINE_BOARDS   4
#define LINE_MASTER   (-1)
#define LINE_FRAMES   4096    // remembered; a power of two
#define LINE_BAUD     115200U // of the master, until it is told another rate
#define LINE_BITS     11U     // 8 data bits, parity and a stop bit, or two stop bits
#define LINE_BAUD_MIN 300U
#define LINE_BAUD_MAX 2000000U
// Modbus RTU's end of a frame at this speed, in cycles.
#define LINE_SILENCE cpu_clock_cycles_of_us(1750U)

enum line_parity { LINE_NONE, LINE_ODD, LINE_EVEN };

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

    uint32_t master_baud;
    uint8_t master_format; // as in UCSR0C
    bool master_strict;    // it hears only what has its own rate and format
    uint64_t master_ready; // the master's transmitter is busy until this cycle
    uint32_t master_rest;  // fraction of that cycle, in units of 1 / master_baud
    unsigned heard;        // index of the next frame the master looks at
    uint64_t corrupted_frames;
    struct wire_log *log; // of what the first board hears; NULL for none
};

void line_init(struct line *line);

// Puts a frame on the line and tells everyone else; collisions spoil both.
struct line_frame *line_start(struct line *line, const struct line_frame *frame);

// Rate and parity of what the master sends from now on, and of all that it still hears well. Before
// it sends at 115200 baud with even parity and hears everything.
void line_set_master(struct line *line, uint32_t baud, enum line_parity parity);

// The master sends bytes back to back, not before `cycle`. Returns the end of the last.
uint64_t line_master_send(struct line *line,
                          const uint8_t *bytes,
                          size_t count,
                          uint64_t cycle);

// The master waits so long before it sends again.
void line_master_pause(struct line *line, uint64_t cycles);

// The next byte that the master has received up to this cycle, or -1. *end is the end of its frame.
int line_master_receive(struct line *line, uint64_t cycle, uint64_t *end);

// True while a board's frame is on its way at this cycle.
bool line_busy(const struct line *line, uint64_t cycle);
