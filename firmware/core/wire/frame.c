// SPDX-License-Identifier: MIT
#include "wire/frame.h"

#include "base/flash.h" // IN_FLASH
#include "wire/crc16.h" // crc16

#define FRAME_MIN_BYTES 4u
#define FUNCTIONS       25u // those with a place in the table
#define IDENTIFICATION  43u // the one that is served outside of it
#define REPLY_OBJECTS   7u  // of an identification: their number, then id, length, text of each
#define EXCEPTION       0x80u

// A length: so many bytes, and as many more as a byte of the frame says; which one, in bits 4, 5.
#define FIXED(bytes) (bytes)
#define COUNTED(bytes, at)                                                               \
    ((bytes) | ((at) == 2u ? 0x10u : (at) == 6u ? 0x20u : 0x30u)) // 2, 6 or 10
#define RULE_AT(rule)    (((rule) >> 2 & 0x0Cu) - 2u)
#define RULE_COUNT(rule) (((rule) & 0x30u) != 0)
#define RULE_BYTES(rule) ((rule) & 0x0Fu)

#define SERVED (RULE_SERVED)
#define TO_ALL (RULE_SERVED | RULE_BROADCAST)

// Every function that has a place in the standard.
static const char requests[FUNCTIONS] IN_FLASH = {
    [1] = (char)(SERVED | FIXED(8u)),
    [2] = (char)(SERVED | FIXED(8u)),
    [3] = (char)(SERVED | FIXED(8u)),
    [4] = (char)(SERVED | FIXED(8u)),
    [5] = (char)(TO_ALL | FIXED(8u)),
    [6] = (char)(TO_ALL | FIXED(8u)),
    [7] = (char)FIXED(4u),
    [8] = (char)(SERVED | FIXED(8u)),
    [11] = (char)FIXED(4u),
    [12] = (char)FIXED(4u),
    [15] = (char)(TO_ALL | COUNTED(9u, 6u)),
    [16] = (char)(TO_ALL | COUNTED(9u, 6u)),
    [17] = (char)(SERVED | FIXED(4u)),
    [20] = (char)((SERVER_FILES ? SERVED : 0u) | COUNTED(5u, 2u)),
    [21] = (char)COUNTED(5u, 2u),
    [22] = (char)(TO_ALL | FIXED(10u)),
    [23] = (char)(SERVED | COUNTED(13u, 10u)),
    [24] = (char)FIXED(6u),
};
static const char replies[FUNCTIONS] IN_FLASH = {
    [1] = (char)COUNTED(5u, 2u),
    [2] = (char)COUNTED(5u, 2u),
    [3] = (char)COUNTED(5u, 2u),
    [4] = (char)COUNTED(5u, 2u),
    [5] = (char)FIXED(8u),
    [6] = (char)FIXED(8u),
    [7] = (char)FIXED(5u),
    [8] = (char)FIXED(8u),
    [11] = (char)FIXED(8u),
    [12] = (char)COUNTED(5u, 2u),
    [15] = (char)FIXED(8u),
    [16] = (char)FIXED(8u),
    [17] = (char)COUNTED(5u, 2u),
    [20] = (char)COUNTED(5u, 2u),
    [21] = (char)COUNTED(5u, 2u),
    [22] = (char)FIXED(10u),
    [23] = (char)COUNTED(5u, 2u),
};

void frame_reset(struct frame *frame)
{
    frame->tried = FRAME_MIN_BYTES - 1u;
}

uint8_t frame_rule(uint8_t function)
{
    if (function == IDENTIFICATION) {
        return SERVED | FIXED(7u);
    }
    return function < FUNCTIONS ? (uint8_t)flash_char(&requests[function]) : 0;
}

uint16_t frame_length_by(const struct frame *frame, uint8_t rule)
{
    uint16_t length = RULE_BYTES(rule);

    return RULE_COUNT(rule) ? (uint16_t)(length + frame->bytes[RULE_AT(rule)]) : length;
}

// Past what was received when that does not reach to its end.
static uint16_t identification_length(const struct frame *frame, uint16_t received)
{
    uint16_t at = REPLY_OBJECTS + 1u;

    for (uint8_t left = frame->bytes[REPLY_OBJECTS]; left != 0; left--) {
        if (at + 1u >= received) {
            break;
        }
        at = (uint16_t)(at + 2u + frame->bytes[at + 1u]);
    }
    return (uint16_t)(at + 2u);
}

static uint16_t reply_length(const struct frame *frame, uint16_t received)
{
    uint8_t function = frame->bytes[1];

    if ((function & EXCEPTION) != 0) {
        return 5;
    }
    if (function == IDENTIFICATION) {
        return identification_length(frame, received);
    }
    return function < FUNCTIONS
               ? frame_length_by(frame, (uint8_t)flash_char(&replies[function]))
               : 0;
}

static bool ends_at(struct frame *frame, uint16_t received, uint16_t length)
{
    if (length <= frame->tried || length > received || crc16(frame->bytes, length) != 0) {
        return false;
    }
    frame->length = length;
    frame_reset(frame);
    return true;
}

enum frame_status frame_look(struct frame *frame,
                             uint16_t received,
                             bool ended,
                             uint8_t address)
{
    bool ours = frame->bytes[0] == address || frame->bytes[0] == 0;

    if (ends_at(frame, received, frame_length_by(frame, frame_rule(frame->bytes[1]))) ||
        (!ours && ends_at(frame, received, reply_length(frame, received)))) {
        return ours ? FRAME_READY : FRAME_FOREIGN;
    }
    if (!ended || received == 0) {
        // A wrong checksum may only mean a frame of another shape: what follows decides.
        frame->tried = received;
        return FRAME_PARTIAL;
    }
    frame_reset(frame);
    if (ends_at(frame, received, received)) {
        return ours ? FRAME_READY : FRAME_FOREIGN;
    }
    frame->length = received;
    return FRAME_BAD;
}

uint16_t frame_seal(struct frame *frame, uint16_t length)
{
    uint16_t crc = crc16(frame->bytes, length);

    frame->bytes[length] = (uint8_t)crc;
    frame->bytes[length + 1u] = (uint8_t)(crc >> 8);
    return (uint16_t)(length + 2u);
}
