// SPDX-License-Identifier: MIT
//
// The serial bus that the master and all boards share (RS-485, half duplex: no sender receives its
// own frames). A frame's whole course is known when it starts, a frame time before anyone has to
// act on it: that is why the boards can run one after the other in quanta shorter than a frame.
//
// All times are cycles of the boards' common clock. The bench calls everything here, except
// bus_start(), which the boards' UARTs call too.
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "bus_frame.h"
#include "cpu_clock.h"
#include "wire_log.h"

#define BUS_BOARDS   4
#define BUS_MASTER   (-1)
#define BUS_FRAMES   4096    // remembered; a power of two
#define BUS_BAUD     115200U // of the master, until bus_set_master()
#define BUS_BITS     11U     // 8 data bits, parity and a stop bit, or two stop bits
#define BUS_BAUD_MIN 300U
#define BUS_BAUD_MAX 2000000U
// Modbus RTU's end of a frame at this speed, in cycles.
#define BUS_SILENCE cpu_clock_cycles_of_us(1750U)

enum bus_parity { BUS_PARITY_NONE, BUS_PARITY_ODD, BUS_PARITY_EVEN };

// A receiver of the frames of all others. A frame stays valid while it is on the bus.
struct bus_listener {
    void *receiver;
    void (*receive)(void *receiver, struct bus_frame *frame);
};

struct bus {
    struct bus_listener listener[BUS_BOARDS]; // by board
    int boards;
    struct bus_frame frame[BUS_FRAMES]; // the last ones, a ring
    unsigned next_frame;                // counts all frames so far
    uint64_t all_quiet;                 // from this cycle on, none of these is under way

    uint32_t master_baud;
    uint8_t master_format;     // as in UCSR0C
    bool master_strict;        // it receives only frames of its own rate and format
    uint64_t master_ready;     // the master's transmitter is busy until this cycle
    uint32_t master_rest;      // fraction of that cycle, in units of 1 / master_baud
    unsigned next_unread;      // index of the next frame the master looks at
    uint64_t corrupted_frames; // collisions so far
    struct wire_log *log;      // of the frames for the first board; NULL for none
};

// An idle bus without boards; the master sends at BUS_BAUD with even parity and receives frames of
// any rate and parity.
void bus_init(struct bus *bus);

// Connects the next board, BUS_BOARDS at most.
void bus_connect(struct bus *bus, const struct bus_listener *listener);

// Puts a frame on the bus and passes it to everyone but its sender. Frames of different senders
// that meet corrupt each other. The frame returned stays valid while it is on the bus; its sender
// may still mark it as corrupted.
struct bus_frame *bus_start(struct bus *bus, const struct bus_frame *frame);

// Sets the rate (BUS_BAUD_MIN to BUS_BAUD_MAX) and parity of what the master sends from now on.
// From now on it receives garbage instead of frames with another rate or parity.
void bus_set_master(struct bus *bus, uint32_t baud, enum bus_parity parity);

// The master sends bytes back to back, not before `cycle`. Returns the end of the last.
uint64_t bus_master_send(struct bus *bus,
                         const uint8_t *bytes,
                         size_t count,
                         uint64_t cycle);

// The master waits this many cycles before it sends again.
void bus_master_pause(struct bus *bus, uint64_t cycles);

// The next byte that the master has received up to this cycle, or -1. *end is the end of its frame.
int bus_master_receive(struct bus *bus, uint64_t cycle, uint64_t *end);

// True while a board's frame that the master has not read is still to end after this cycle.
bool bus_busy(const struct bus *bus, uint64_t cycle);
