// SPDX-License-Identifier: MIT
// What a fuzzer's input means: a row of things that happen on the serial line. Checksums are put
// right here, so that most of what is tried reaches the server instead of ending at its door.
//
//     byte 0   bits 0 to 2 what (enum script_kind); bit 3 set: no silence before;
//              bit 4 set: no silence after; bit 5 set: the board does not look meanwhile
//     byte 1   number of bytes n, where there are any (clipped to what is left)
//     n bytes
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define SCRIPT_ADDRESS   17u // the board's
#define SCRIPT_BYTES_MAX 260u

enum script_kind {
    SCRIPT_REQUEST = 0,   // to the board: n bytes of PDU, checksum right
    SCRIPT_BYTES = 1,     // n bytes as they are
    SCRIPT_BROADCAST = 2, // n bytes of PDU, checksum right
    SCRIPT_FOREIGN = 3,   // n bytes, the first an address; checksum right
    SCRIPT_SPOILT = 4,    // to the board: n bytes of PDU, checksum wrong
    SCRIPT_GAP = 5,       // shorter than the silence that ends a frame
    SCRIPT_SILENCE = 6,
    SCRIPT_PROBE = 7, // silence, a request that must be answered, silence
};

struct script {
    const uint8_t *data;
    size_t left;
};

struct script_item {
    enum script_kind kind;
    bool silence_before;
    bool silence_after;
    bool seen_late;
    uint8_t bytes[SCRIPT_BYTES_MAX]; // as they go on the line
    uint16_t count;
};

// The next item; false at the end.
bool script_next(struct script *script, struct script_item *item);

// CRC-16 of Modbus, four bits at a time: written apart from the firmware's.
uint16_t script_crc(const uint8_t *bytes, size_t count);

// True for 4 to 256 bytes to this address, or to all, with a right checksum.
bool script_is_frame(const uint8_t *bytes, size_t count, uint8_t address);
