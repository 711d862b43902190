// SPDX-License-Identifier: MIT
// Entries of a line packed into 1 to 4 bytes each. The queue holds them so, and a compact block
// brings them so. A single pixel whose count is near the count of the entry before takes one byte,
// so that pixels with counts of their own cost a byte each on the bus and in memory.
//
//     first byte   more bytes          entry (count, repeat)        d is added to the last count
//     00..70       -                   d = first - 38, repeat 1     -56..56
//     71..76       d                   repeat = first - 6F, 2..7    -128..127
//     77           d, repeat           repeat 0..255                -128..127
//     78..7F       low                 d = (first, low) - 7C00,     -1024..1023
//                                      repeat 1
//     80..FF       c, repeat (2)       count = (first, c) as 15 bits, signed
//
// Only the first word of a parameter may be too large for 15 bits with a sign: its reader takes the
// lowest 15 bits, because the check allows no more.
//
// The last count is the count of the entry before, whatever that entry is: of a mark its word, of a
// parameter its first word. Before the first entry the last count is 0. Sums are modulo 2^16.
//
// Main loop only.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "line/segment.h" // struct segment

// A place in packed bytes. A copy is a second place in the same bytes.
struct segment_reader {
    // The bytes.
    uint8_t *bytes;
    // The bytes are a ring of mask + 1 bytes, a power of two; UINT16_MAX: they are no ring.
    uint16_t mask;
    // Index of the next byte; runs freely and is masked when it is used.
    uint16_t at;
    // Count of the entry before.
    int16_t last;
};

// The largest first byte of an entry of one byte, and the first byte of the difference 0.
#define SEGMENT_NEAR_LAST 0x70u
#define SEGMENT_NEAR_ZERO 0x38u
// First byte of a run. Short runs, below it, have their repeat added to SEGMENT_SHORT_RUN.
#define SEGMENT_RUN       0x77u
#define SEGMENT_SHORT_RUN 0x6Fu
// The flag in the first byte of an entry in full.
#define SEGMENT_IN_FULL 0x80u
// Bytes of the longest entry.
#define SEGMENT_MOST 4u
// The bits of a parameter's first word that count.
#define SEGMENT_PARAMETER 0x7FFFu

// Bytes, 1..SEGMENT_MOST, of the entry that begins with this byte.
static inline uint8_t segment_packed_size(uint8_t first)
{
    if (first <= SEGMENT_NEAR_LAST) {
        return 1;
    }
    if (first >= SEGMENT_IN_FULL) {
        return SEGMENT_MOST;
    }
    return first == SEGMENT_RUN ? 3 : 2;
}

// Read the next entry and pass it. The bytes must hold all of the entry: nothing is checked.
struct segment segment_unpack(struct segment_reader *reader);
