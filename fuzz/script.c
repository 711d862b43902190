// SPDX-License-Identifier: MIT
#include "script.h"

#include <string.h>

#define FRAME_BYTES_MAX 256u
#define PDU_BYTES_MAX   253u
#define ITEM_KIND       0x07u
#define ITEM_JOINED     0x08u // no silence before this item
#define ITEM_RUNS_ON    0x10u // no silence behind this item
#define ITEM_SEEN_LATE  0x20u

// The checksum of a frame, computed four bits at a time.
uint16_t script_crc(const uint8_t *bytes, size_t count)
{
    static const uint16_t of_nibble[16] = {
        0x0000,
        0xCC01,
        0xD801,
        0x1400,
        0xF001,
        0x3C00,
        0x2800,
        0xE401,
        0xA001,
        0x6C00,
        0x7800,
        0xB401,
        0x5000,
        0x9C01,
        0x8801,
        0x4400,
    };
    uint16_t crc = 0xFFFF;

    for (size_t i = 0; i < count; i++) {
        crc = (uint16_t)(crc ^ bytes[i]);
        crc = (uint16_t)((crc >> 4) ^ of_nibble[crc & 15u]);
        crc = (uint16_t)((crc >> 4) ^ of_nibble[crc & 15u]);
    }
    return crc;
}

bool script_is_frame(const uint8_t *bytes, size_t count, uint8_t address)
{
    return count >= 4 && count <= FRAME_BYTES_MAX &&
           (bytes[0] == address || bytes[0] == 0) && script_crc(bytes, count) == 0;
}

static uint8_t take_byte(struct script *script)
{
    if (script->left == 0) {
        return 0;
    }
    script->left--;
    return *script->data++;
}

static void append(struct script_item *item, uint8_t byte)
{
    item->bytes[item->count] = byte;
    item->count++;
}

static void take_bytes(struct script *script, struct script_item *item)
{
    uint16_t count = take_byte(script);
    uint16_t most = item->kind == SCRIPT_BYTES ? UINT8_MAX : PDU_BYTES_MAX;

    if (count > most) {
        count = most;
    }
    if (count > script->left) {
        count = (uint16_t)script->left;
    }
    for (uint16_t i = 0; i < count; i++) {
        append(item, take_byte(script));
    }
}

static void seal(struct script_item *item, uint16_t spoil)
{
    uint16_t crc = (uint16_t)(script_crc(item->bytes, item->count) ^ spoil);

    append(item, (uint8_t)crc);
    append(item, (uint8_t)(crc >> 8));
}

// Address the item to another board, whatever address was given.
static void make_foreign(struct script_item *item)
{
    if (item->count != 0 && (item->bytes[0] == 0 || item->bytes[0] == SCRIPT_ADDRESS)) {
        item->bytes[0] = SCRIPT_ADDRESS + 1u;
    }
}

static void fill(struct script *script, struct script_item *item)
{
    if (item->kind >= SCRIPT_GAP) {
        return;
    }
    if (item->kind == SCRIPT_REQUEST || item->kind == SCRIPT_SPOILT) {
        append(item, SCRIPT_ADDRESS);
    } else if (item->kind == SCRIPT_BROADCAST) {
        append(item, 0);
    }
    take_bytes(script, item);
    if (item->kind == SCRIPT_FOREIGN) {
        make_foreign(item);
    }
    if (item->kind != SCRIPT_BYTES) {
        seal(item, item->kind == SCRIPT_SPOILT ? 0x0100u : 0u);
    }
}

bool script_next(struct script *script, struct script_item *item)
{
    if (script->left == 0) {
        return false;
    }
    uint8_t head = take_byte(script);

    item->kind = (enum script_kind)(head & ITEM_KIND);
    item->silence_before = (head & ITEM_JOINED) == 0;
    item->silence_after = (head & ITEM_RUNS_ON) == 0;
    item->seen_late = (head & ITEM_SEEN_LATE) != 0;
    item->count = 0;
    fill(script, item);
    return true;
}
