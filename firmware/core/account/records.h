// SPDX-License-Identifier: MIT
// What happened at the newest pixel edges of a line: the axis's position, the expected position,
// and how far the clock's edge lay from its planned time. A new record overwrites the oldest one.
// Main loop only.
//
// At high pixel rates a host cannot read a record of each pixel. records_thin() therefore keeps the
// records of every Nth pixel and of every deviation. A deviation is an actual position that is not
// the expected one, or an edge error that has changed by more than a limit since the newest record
// that was kept. The newest pixel always has a record, which the next pixel overwrites if it is not
// to be kept.
//
//     pixel       ...  4      8      9      11           every 4, a deviation at pixel 9
//     kept              (4)    (8)    (9)    (11)        records_get(0) is pixel 4, 3 are shown
//
// `made` counts the records of the line, so that a host knows how many it has not read.
//
// The account writes a record as it passes a pixel edge; the pixel clock's edges bring the errors,
// before their pixel is passed or afterwards; the registers read the records. The ring of records:
//
//     kept[]     | newest - 2 | newest - 1 | newest | oldest ... |    RECORDS_KEPT slots
//
// Without FEATURE_CLOCK_STATISTICS nobody notes edge errors: they read as 0 and take no memory.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "build_features.h" // FEATURE_CLOCK_STATISTICS

// Records kept, up to 20: what one read request can carry. The build sets fewer for the smaller
// board. Two at least: one may be of a pixel that is passing.
#if !defined(RECORDS_KEPT)
#define RECORDS_KEPT 20
#endif

// Pixels by which the account may lag behind the clock's edges; a power of two.
#define RECORDS_EARLY 8u

// A record as it is shown.
struct pixel_record {
    // Low 16 bits of the pixel's number; 1: the end of the line's first pixel.
    uint16_t pixel;
    // Clock edge minus planned edge, ticks; positive when the clock's edge came late.
    int16_t edge_error_ticks;
    // Expected position at the edge: signed steps of the line.
    int32_t expected_steps;
    // Actual position at the edge: signed steps of the line.
    int32_t actual_steps;
};

// A record as it is kept, which is shorter.
struct kept_record {
    // Actual position at the edge: signed steps of the line.
    int32_t actual_steps;
    // Actual minus expected position, steps, modulo 2^16.
    int16_t beyond_steps;
#if FEATURE_CLOCK_STATISTICS
    // As in struct pixel_record; 0 until the edge's error is known.
    int16_t edge_error_ticks;
#endif
    // Low 16 bits of the pixel's number.
    uint16_t pixel;
};

// The records of an axis's line, of which the functions below write every member.
struct records {
    // Slot of the newest record, 0..RECORDS_KEPT-1.
    uint8_t newest;
    // Records in kept[], the newest one included, 0..RECORDS_KEPT.
    uint8_t count;
    // The newest record is not to be kept: the next pixel's record takes its slot.
    bool passing;
    // Records of the line that were to be kept; wraps.
    uint16_t made;
    // Pixels until the next one that is kept in any case, 1..records_thinned.every.
    uint16_t to_next;
#if FEATURE_CLOCK_STATISTICS
    // Edge error of the newest record that was to be kept, ticks.
    int16_t shown_ticks;
    // Edge errors of the pixels after the newest record, ticks, by the low bits of the pixels'
    // numbers; 0: not known. The account of an axis may lag some pixels behind the clock.
    int16_t early_ticks[RECORDS_EARLY];
#endif
    // The ring of the records.
    struct kept_record kept[RECORDS_KEPT];
};

// Which records are kept, the same for all axes. records_thin() sets it.
struct records_thinning {
    // The record of every Nth pixel is kept, 1..65535.
    uint16_t every;
    // An edge error that has changed by more than this is a deviation, ticks.
    uint16_t error_ticks;
};

// For ledger_waypoints.S and records.c alone.
extern struct records_thinning records_thinned;

// Keep the record of every Nth pixel (every: 1 or more), and the records whose edge error has
// changed by more than `error_ticks`. The error counts from the next record on, the number from the
// next line or the next Nth pixel on. To be called before the first line.
void records_thin(uint16_t every, uint16_t error_ticks);

// A line begins: discard all records and all errors of edges.
void records_reset(struct records *records);

// The axis passed the edge of this pixel, the next one of the line. pixel: low 16 bits of its
// number. actual_steps: position at the edge, signed steps of the line. expected_steps: the low 16
// bits are enough, because actual and expected position are nearly the same.
void records_add(struct records *records,
                 uint16_t pixel,
                 int32_t actual_steps,
                 uint16_t expected_steps);

// Note the error of the clock's edge, ticks, at the end of a pixel that is 1..RECORDS_EARLY after
// the pixel of the newest record. The caller has checked that.
static inline void records_note_early(struct records *records,
                                      uint16_t pixel,
                                      int16_t error_ticks)
{
#if FEATURE_CLOCK_STATISTICS
    records->early_ticks[pixel & (RECORDS_EARLY - 1u)] = error_ticks;
#else
    (void)records;
    (void)pixel;
    (void)error_ticks;
#endif
}

// Note how far the clock's edge at the end of a pixel lay from its planned time, ticks. pixel: low
// 16 bits of its number. Where the pixel has no record of its own, the newest record takes the
// error while it is passing, else the error is dropped. The error of a pixel up to RECORDS_EARLY
// after the newest one is kept until that pixel is passed; one still further ahead is dropped.
void records_note_error(struct records *records, uint16_t pixel, int16_t error_ticks);

#if FEATURE_CLOCK_STATISTICS
// The error of the newest pixel's edge is known, and is in its record: keep the record if the error
// is a deviation. For ledger_waypoints.S and records.c alone.
void records_note_newest(struct records *records, int16_t error_ticks);

// records_note_error() for the newest pixel. The line must have one.
static inline void records_note_last(struct records *records, int16_t error_ticks)
{
    records->kept[records->newest].edge_error_ticks = error_ticks;
    if (error_ticks != records->shown_ticks) {
        records_note_newest(records, error_ticks);
    }
}
#endif

// Number of records to be read, 0..RECORDS_KEPT: the newest one does not count while it is passing.
static inline uint8_t records_shown(const struct records *records)
{
    return records->passing ? (uint8_t)(records->count - 1u) : records->count;
}

// Record `number`, 0..count-1; 0 is the oldest. After the shown records comes the newest pixel's
// record, if that one is passing. The caller checks the number.
struct pixel_record records_get(const struct records *records, uint8_t number);

// Write `count` records from `number` on to *to, 12 bytes each, big-endian as the registers show
// them; zeros where no record is shown. On boards of several axes only.
void records_write(const struct records *records,
                   uint8_t number,
                   uint8_t count,
                   uint8_t *to);

// One word (0..5) of record `number` (0..count-1), in the registers' order: pixel, expected (high,
// low), actual (high, low), error of the clock's edge.
uint16_t records_word(const struct records *records, uint8_t number, uint8_t word);
