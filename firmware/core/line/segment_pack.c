// SPDX-License-Identifier: MIT
#include "line/segment_pack.h"

#include "base/apart.h" // APART

#define WIDE      0x78u
#define WIDE_ZERO 0x7C00u // the two bytes of the difference 0

static uint8_t next_byte(struct segment_reader *reader)
{
    BY_POINTER_SMALL(reader);
    uint8_t byte = reader->bytes[reader->at & reader->mask];

    reader->at++;
    return byte;
}

static uint16_t next_word(struct segment_reader *reader, uint8_t high)
{
    return (uint16_t)((uint16_t)high << 8 | next_byte(reader));
}

// The lowest 15 bits, of which the highest is the sign.
static int16_t signed_15(uint16_t word)
{
    return (int16_t)((word & 0x7FFFu) | ((uint16_t)(word << 1) & 0x8000u));
}

// Read what is behind the first byte of an entry of more than one byte.
static struct segment APART unpack_long(struct segment_reader *reader, uint8_t first)
{
    struct segment entry = {.repeat = 1};
    uint16_t word = next_word(reader, first);
    uint16_t difference = (uint16_t)(word - WIDE_ZERO);

    if (first >= SEGMENT_IN_FULL) {
        reader->last = signed_15(word);
        entry.repeat = next_word(reader, next_byte(reader));
        entry.count = reader->last;
        return entry;
    }
    if (first < WIDE) {
        difference = (uint16_t)(int8_t)(uint8_t)word;
        entry.repeat = first == SEGMENT_RUN ? next_byte(reader)
                                            : (uint8_t)(first - SEGMENT_SHORT_RUN);
    }
    reader->last = (int16_t)((uint16_t)reader->last + difference);
    entry.count = reader->last;
    return entry;
}

struct segment segment_unpack(struct segment_reader *reader)
{
    uint16_t at = reader->at;
    uint8_t first = reader->bytes[at & reader->mask];

    reader->at = (uint16_t)(at + 1u);
    if (first > SEGMENT_NEAR_LAST) {
        return unpack_long(reader, first);
    }
    reader->last = (int16_t)((uint16_t)reader->last + first - SEGMENT_NEAR_ZERO);
    return (struct segment){.count = reader->last, .repeat = 1};
}
