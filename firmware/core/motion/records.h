// SPDX-License-Identifier: MIT
// What happened at the newest pixel edges of a line: where the motor was, where it should have been,
// and how far the clock's edge lay from its plan. The oldest record is overwritten. Main loop only.
#pragma once

#include <stdbool.h>
#include <stdint.h>

// Records kept, up to 20: what one read can carry. The build gives the smaller board fewer.
#if !defined(RECORDS_KEPT)
#define RECORDS_KEPT 20u
#endif

struct pixel_record {
    uint16_t pixel; // low 16 bits of the number, 1 = end of the line's first pixel
    int16_t edge_error_ticks; // clock edge minus planned edge
    int32_t expected_steps;   // of the line, signed
    int32_t actual_steps;
};

struct records {
    uint8_t next; // slot for the next record
    uint8_t count;
    uint16_t newest_pixel; // low 16 bits
    struct {
        int32_t actual_steps;
        int16_t beyond_steps; // actual minus expected
        int16_t edge_error_ticks;
    } kept[RECORDS_KEPT];
};

// A line begins: no records.
void records_reset(struct records *records);

// The edge of this pixel, the next one of the line, was passed. expected_steps: low 16 bits, because
// the two are nearly the same.
void records_add(struct records *records,
                 uint16_t pixel,
                 int32_t actual_steps,
                 uint16_t expected_steps);

// How far the clock's edge at the end of a pixel lay from its plan; nothing where that pixel's record
// is no longer kept.
void records_note_error(struct records *records, uint16_t pixel, int16_t error_ticks);

// Record `number` of records->count, 0 the oldest.
struct pixel_record records_get(const struct records *records, uint8_t number);

// The same, word by word as the registers show it: pixel, expected (high, low), actual (high, low),
// error of the clock's edge.
uint16_t records_word(const struct records *records, uint8_t number, uint8_t word);
