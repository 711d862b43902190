// SPDX-License-Identifier: MIT
#include "account/records.h"

#include <stddef.h> // NULL

#include "base/apart.h" // APART

#define RECORD_BYTES 12u // as the registers show it

struct records_thinning records_thinned;

void records_thin(uint16_t every, uint16_t error_ticks)
{
    records_thinned.every = every;
    records_thinned.error_ticks = error_ticks;
}

void records_reset(struct records *records)
{
    records->newest = RECORDS_KEPT - 1u;
    records->count = 0;
    records->passing = false;
    records->made = 0;
    records->to_next = records_thinned.every;
#if FEATURE_CLOCK_STATISTICS
    records->shown_ticks = 0;
    for (uint8_t i = 0; i < RECORDS_EARLY; i++) {
        records->early_ticks[i] = 0;
    }
#endif
}

static void keep_newest(struct records *records)
{
    records->passing = false;
    records->made++;
}

#if FEATURE_CLOCK_STATISTICS
// Keep the record if the error is another than the one before.
APART void records_note_newest(struct records *records, int16_t error)
{
    int16_t shown = records->shown_ticks;
    // Of any two words the difference fits 16 bits without a sign.
    uint16_t change = error < shown ? (uint16_t)((uint16_t)shown - (uint16_t)error)
                                    : (uint16_t)((uint16_t)error - (uint16_t)shown);

    if (records->passing && change > records_thinned.error_ticks) {
        keep_newest(records);
    }
    if (!records->passing) {
        records->shown_ticks = error;
    }
}

// Give the newest record the error of an edge that came before its pixel.
static void take_early(struct records *records, struct kept_record *record, uint8_t pixel)
{
    int16_t *place = &records->early_ticks[pixel & (RECORDS_EARLY - 1u)];
    int16_t early_ticks = *place;

    record->edge_error_ticks = early_ticks;
    if (early_ticks != 0) {
        *place = 0;
        records_note_newest(records, early_ticks);
    }
}

static int16_t error_of(const struct kept_record *record)
{
    return record->edge_error_ticks;
}
#else
static void take_early(struct records *records, struct kept_record *record, uint8_t pixel)
{
    (void)pixel;
    (void)records;
    (void)record;
}

static int16_t error_of(const struct kept_record *record)
{
    (void)record;
    return 0;
}
#endif

// Move on to the slot of the next record.
static struct kept_record *next_slot(struct records *records)
{
    if (!records->passing) {
        records->newest++;
        if (records->newest == RECORDS_KEPT) {
            records->newest = 0;
        }
        if (records->count < RECORDS_KEPT) {
            records->count++;
        }
    }
    return &records->kept[records->newest];
}

void records_add(struct records *records,
                 uint16_t pixel,
                 int32_t actual_steps,
                 uint16_t expected_steps)
{
    struct kept_record *record = next_slot(records);
    int16_t beyond_steps = (int16_t)(uint16_t)((uint16_t)actual_steps - expected_steps);

    record->pixel = pixel;
    record->actual_steps = actual_steps;
    record->beyond_steps = beyond_steps;
    records->passing = true;
    records->to_next--;
    if (records->to_next == 0) {
        records->to_next = records_thinned.every;
        keep_newest(records);
    } else if (beyond_steps != 0) {
        keep_newest(records);
    }
    take_early(records, record, (uint8_t)pixel);
}

static uint8_t slot_of(const struct records *records, uint8_t number)
{
    uint8_t back = (uint8_t)(records->count - 1u - number); // 0: the newest
    uint8_t slot = records->newest;

    if (slot < back) {
        slot = (uint8_t)(slot + RECORDS_KEPT);
    }
    return (uint8_t)(slot - back);
}

#if FEATURE_CLOCK_STATISTICS
// The record of a pixel; the newest one stands for a pixel that was passed over, or NULL.
static APART struct kept_record *search_record(struct records *records, uint16_t pixel)
{
    struct kept_record *newest = &records->kept[records->newest];
    uint8_t slot = records->newest;

    for (uint8_t left = records->count; left != 0; left--) {
        struct kept_record *record = &records->kept[slot];
        int16_t behind = (int16_t)(uint16_t)(record->pixel - pixel);
        if (behind == 0) {
            return record;
        }
        if (behind < 0) {
            return record == newest || !records->passing ? NULL : newest;
        }
        slot = slot == 0 ? RECORDS_KEPT - 1u : (uint8_t)(slot - 1u);
    }
    return records->passing ? newest : NULL;
}

// The same. Nearly always every pixel has a record, so that its place is known.
static struct kept_record *record_of(struct records *records, uint16_t pixel)
{
    uint8_t slot = records->newest;
    uint16_t back = (uint16_t)(records->kept[slot].pixel - pixel);

    if (back < records->count && back <= slot &&
        records->kept[slot - back].pixel == pixel) {
        return &records->kept[slot - back];
    }
    return search_record(records, pixel);
}

// Apart from the newest pixel's: what it keeps in registers would cost that one as much again.
static APART void note_other(struct records *records, uint16_t pixel, int16_t error_ticks)
{
    struct kept_record *newest = &records->kept[records->newest];
    uint16_t ahead = records->count == 0 ? pixel : (uint16_t)(pixel - newest->pixel);

    if ((uint16_t)(ahead - 1u) < RECORDS_EARLY) {
        records_note_early(records, pixel, error_ticks);
        return;
    }
    struct kept_record *record = record_of(records, pixel);
    if (record != NULL) {
        record->edge_error_ticks = error_ticks;
        if (record == newest) {
            records_note_newest(records, error_ticks);
        }
    }
}

void records_note_error(struct records *records, uint16_t pixel, int16_t error_ticks)
{
    const struct kept_record *newest = &records->kept[records->newest];

    if (newest->pixel == pixel && records->count != 0) {
        records_note_last(records, error_ticks);
    } else {
        note_other(records, pixel, error_ticks);
    }
}
#else
void records_note_error(struct records *records, uint16_t pixel, int16_t error_ticks)
{
    (void)records;
    (void)pixel;
    (void)error_ticks;
}
#endif

struct pixel_record records_get(const struct records *records, uint8_t number)
{
    const struct kept_record *record = &records->kept[slot_of(records, number)];

    return (struct pixel_record){
        .pixel = record->pixel,
        .edge_error_ticks = error_of(record),
        .expected_steps = record->actual_steps - record->beyond_steps,
        .actual_steps = record->actual_steps,
    };
}

uint16_t records_word(const struct records *records, uint8_t number, uint8_t word)
{
    BY_POINTER_SMALL(records);
    const struct kept_record *record = &records->kept[slot_of(records, number)];
    int32_t steps = record->actual_steps;

    if (word == 0) {
        return record->pixel;
    }
    if (word == 5) {
        return (uint16_t)error_of(record);
    }
    if (word <= 2) {
        steps -= record->beyond_steps;
    }
    return (word & 1u) != 0 ? (uint16_t)((uint32_t)steps >> 16) : (uint16_t)steps;
}

#if SEVERAL_AXES
// Big-endian. Returns the place behind it.
static inline uint8_t *put_16(uint8_t *to, uint16_t word)
{
    to[0] = (uint8_t)(word >> 8);
    to[1] = (uint8_t)word;
    return to + 2;
}

static inline uint8_t *put_32(uint8_t *to, uint32_t word)
{
    to = put_16(to, (uint16_t)(word >> 16));
    return put_16(to, (uint16_t)word);
}

void records_write(const struct records *records,
                   uint8_t number,
                   uint8_t count,
                   uint8_t *to)
{
    uint8_t shown = records_shown(records);
    uint8_t slot = number < shown ? slot_of(records, number) : 0;
    const struct kept_record *record = &records->kept[slot];

    for (; count != 0 && number < shown; count--) {
        uint32_t actual_steps = (uint32_t)record->actual_steps;

        to = put_16(to, record->pixel);
        to = put_32(to, (uint32_t)(record->actual_steps - record->beyond_steps));
        to = put_32(to, actual_steps);
        to = put_16(to, (uint16_t)error_of(record));
        number++;
        record++;
        if (record == &records->kept[RECORDS_KEPT]) {
            record = records->kept;
        }
    }
    for (; count != 0; count--) {
        for (uint8_t left = RECORD_BYTES; left != 0; left--) {
            *to++ = 0;
        }
    }
}
#endif
