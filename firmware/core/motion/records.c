// SPDX-License-Identifier: MIT
#include "motion/records.h"

void records_reset(struct records *records)
{
    records->next = 0;
    records->count = 0;
}

void records_add(struct records *records,
                 uint16_t pixel,
                 int32_t actual_steps,
                 uint16_t expected_steps)
{
    uint8_t slot = records->next;

    records->newest_pixel = pixel;
    records->kept[slot].actual_steps = actual_steps;
    records->kept[slot].beyond_steps =
        (int16_t)(uint16_t)((uint16_t)actual_steps - expected_steps);
    records->kept[slot].edge_error_ticks = 0;
    records->next = slot == RECORDS_KEPT - 1u ? 0 : (uint8_t)(slot + 1u);
    if (records->count < RECORDS_KEPT) {
        records->count++;
    }
}

// The slot `back` records (1..RECORDS_KEPT) before the next one.
static uint8_t slot_before_next(const struct records *records, uint8_t back)
{
    uint8_t next = records->next;

    if (next < back) {
        next = (uint8_t)(next + RECORDS_KEPT);
    }
    return (uint8_t)(next - back);
}

void records_note_error(struct records *records, uint16_t pixel, int16_t error_ticks)
{
    uint16_t behind = (uint16_t)(records->newest_pixel - pixel);

    if (behind < records->count) {
        uint8_t slot = slot_before_next(records, (uint8_t)(behind + 1u));
        records->kept[slot].edge_error_ticks = error_ticks;
    }
}

static uint8_t slot_of(const struct records *records, uint8_t number)
{
    return slot_before_next(records, (uint8_t)(records->count - number));
}

static uint16_t pixel_of(const struct records *records, uint8_t number)
{
    return (uint16_t)(records->newest_pixel - records->count + 1u + number);
}

struct pixel_record records_get(const struct records *records, uint8_t number)
{
    uint8_t slot = slot_of(records, number);
    int32_t actual_steps = records->kept[slot].actual_steps;

    return (struct pixel_record){
        .pixel = pixel_of(records, number),
        .edge_error_ticks = records->kept[slot].edge_error_ticks,
        .expected_steps = actual_steps - records->kept[slot].beyond_steps,
        .actual_steps = actual_steps,
    };
}

uint16_t records_word(const struct records *records, uint8_t number, uint8_t word)
{
    uint8_t slot = slot_of(records, number);
    int32_t steps = records->kept[slot].actual_steps;

    if (word == 0) {
        return pixel_of(records, number);
    }
    if (word == 5) {
        return (uint16_t)records->kept[slot].edge_error_ticks;
    }
    if (word <= 2) {
        steps -= records->kept[slot].beyond_steps;
    }
    return (word & 1u) != 0 ? (uint16_t)((uint32_t)steps >> 16) : (uint16_t)steps;
}
