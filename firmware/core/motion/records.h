// SPDX-License-Identifier: MIT
// What happened at the newest pixel edges of a line: the axis's position, the expected position,
// and how far the clock's edge lay from its planned time. A new record overwrites the oldest one.
// Main loop only.
//
//     pixel       ...  7      8      9      10           newest_pixel 10, count 3, RECORDS_KEPT 3
//     kept              (8)    (9)    (10)               records_get(0) is pixel 8
#pragma once

#include <stdbool.h>
#include <stdint.h>

// Records kept, up to 20: what one read request can carry. The build sets fewer for the smaller
// board.
#if !defined(RECORDS_KEPT)
#define RECORDS_KEPT 20u
#endif

struct pixel_record {
    // Low 16 bits of the pixel's number; 1: the end of the line's first pixel.
    uint16_t pixel;
    // Clock edge minus planned edge, ticks.
    int16_t edge_error_ticks;
    // Expected position at the edge: signed steps of the line.
    int32_t expected_steps;
    // Actual position at the edge: signed steps of the line.
    int32_t actual_steps;
};

// Records are kept in 8 bytes each; records_get() makes a struct pixel_record of them.
struct records {
    // Slot for the next record.
    uint8_t next;
    // Records kept so far.
    uint8_t count;
    // Low 16 bits of the newest record's pixel.
    uint16_t newest_pixel;
    struct {
        int32_t actual_steps;
        // Actual minus expected position.
        int16_t beyond_steps;
        int16_t edge_error_ticks;
    } kept[RECORDS_KEPT];
};

// A line begins: discard all records.
void records_reset(struct records *records);

// The axis passed the edge of this pixel, the next one of the line. expected_steps: the low 16 bits
// are enough, because actual and expected position are nearly the same.
void records_add(struct records *records,
                 uint16_t pixel,
                 int32_t actual_steps,
                 uint16_t expected_steps);

// Note how far the clock's edge at the end of a pixel lay from its planned time. Does nothing when
// that pixel's record is no longer kept.
void records_note_error(struct records *records, uint16_t pixel, int16_t error_ticks);

// Record `number`, 0..count-1; 0 is the oldest.
struct pixel_record records_get(const struct records *records, uint8_t number);

// The same, word by word as the registers show it: pixel, expected (high, low), actual (high, low),
// error of the clock's edge.
uint16_t records_word(const struct records *records, uint8_t number, uint8_t word);
