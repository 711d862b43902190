// SPDX-License-Identifier: MIT
//
// The serial line that the master and all boards share (RS-485, half duplex: nobody hears himself).
// A frame's whole course is known when it starts, a frame time before anyone has to act on it: that
// is what lets the boards run one after the other in quanta shorter than a frame.
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "uart.h"
#include "wire_log.h"

#define BUS_BOARDS   4
#define BUS_MASTER   (-1)
#define BUS_FRAMES   4096 // remembered; a power of two
#define BUS_CPU_HZ   16000000U
#define BUS_BAUD     115200U // of the master, until it is told another rate
#define BUS_BITS     11U     // 8 data bits, parity and a stop bit, or two stop bits
#define BUS_BAUD_MIN 300U
#define BUS_BAUD_MAX 2000000U
#define BUS_SILENCE                                                                     \
    28000U // 1750 us: Modbus RTU's end of a frame at this speed, in cycles

enum bus_parity { BUS_PARITY_NONE, BUS_PARITY_ODD, BUS_PARITY_EVEN };

struct bus_frame {
    uint64_t start, end;
    uint32_t bit_cycles_x1000;
    int sender;
    uint8_t data;
    uint8_t format; // parity and data bits, as in UCSR0C
    bool corrupted; // by a collision, or cut off
};

struct bus {
    struct uart *uart[BUS_BOARDS];
    int boards;
    struct bus_frame frame[BUS_FRAMES];
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

void bus_init(struct bus *bus);

// Puts a frame on the line and tells everyone else; collisions spoil both.
struct bus_frame *bus_start(struct bus *bus, const struct bus_frame *frame);

// Rate and parity of what the master sends from now on, and of all that it still hears well. Before
// it sends at 115200 baud with even parity and hears everything.
void bus_set_master(struct bus *bus, uint32_t baud, enum bus_parity parity);

// The master sends bytes back to back, not before `cycle`. Returns the end of the last.
uint64_t bus_master_send(struct bus *bus,
                          const uint8_t *bytes,
                          size_t count,
                          uint64_t cycle);

// The master waits so long before it sends again.
void bus_master_pause(struct bus *bus, uint64_t cycles);

// The next byte that the master has received up to this cycle, or -1. *end is the end of its frame.
int bus_master_receive(struct bus *bus, uint64_t cycle, uint64_t *end);

// True while a board's frame is on its way at this cycle.
bool bus_busy(const struct bus *bus, uint64_t cycle);
