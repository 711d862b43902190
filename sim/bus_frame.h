// SPDX-License-Identifier: MIT
//
// One frame on the serial bus, and what its sender and a receiver must agree on. The frame's whole
// course is known when it starts.
//
//   idle ----\____/= 5 to 8 data bits =/= parity =/---- stop, idle
//            start bit
//            |<--------------- start to end -------------->|
#pragma once

#include <stdbool.h>
#include <stdint.h>

// Bits of a frame's format, as in UCSR0C.
#define BUS_FORMAT_PARITY     0x30U
#define BUS_FORMAT_ODD_PARITY 0x10U // of these
#define BUS_FORMAT_DATA_BITS  0x06U // 5 + (this >> 1) data bits

// A receiver that samples in the middle of bits loses step beyond about 4.5 % over 11 bits.
#define BUS_SPEED_TOLERANCE_PER_MILLE 45

struct bus_frame {
    uint64_t start, end;       // cycles
    uint32_t bit_cycles_x1000; // the length of one bit, in thousandths of a cycle
    int sender;                // a board's index, or BUS_MASTER
    uint8_t data;              // the lowest bit is sent first
    uint8_t format;            // parity and data bits
    bool corrupted;            // by a collision, or cut off
};

// True if two bit lengths (x1000) are so near to each other that a receiver with one of them takes
// in a frame with the other. The tolerance is in parts of `whole`, which is one of the two.
static inline bool bus_speeds_fit(uint32_t a_x1000,
                                  uint32_t b_x1000,
                                  uint32_t whole_x1000)
{
    uint32_t difference = (a_x1000 > b_x1000) ? a_x1000 - b_x1000 : b_x1000 - a_x1000;

    return difference <= whole_x1000 / 1000 * BUS_SPEED_TOLERANCE_PER_MILLE;
}
