// SPDX-License-Identifier: MIT
#include "wire/frame.h"

#include "base/apart.h"     // APART
#include "base/flash.h"     // IN_FLASH
#include "base/interlude.h" // interlude
#include "build_features.h" // FEATURE_*
#include "wire/crc16.h"     // crc16

#define FRAME_MIN_BYTES 4u
#define FUNCTIONS       25u // functions with a place in the table
#define IDENTIFICATION 43u // the one function that is served without a place in the table
#define READ_STATUS    7u
#define EXCEPTION      0x80u

// The length in a rule: a fixed number of bytes, to which a byte of the frame may add. Bits 4 and 5
// tell which byte that is; 0: none.
#define FIXED(bytes) (bytes)
#define COUNTED(bytes, at)                                                               \
    ((bytes) | ((at) == 2u ? 0x10u : (at) == 6u ? 0x20u : 0x30u)) // 2, 6 or 10
#define RULE_AT(rule)    (((rule) >> 2 & 0x0Cu) - 2u)
#define RULE_COUNT(rule) (((rule) & 0x30u) != 0)
#define RULE_BYTES(rule) ((rule) & 0x0Fu)

#define SERVED      (RULE_SERVED)
#define TO_ALL      (RULE_SERVED | RULE_BROADCAST)
#define IF(feature) ((feature) ? RULE_SERVED : 0u)

// The rule of every function that the standard defines, served here or not: the length of a foreign
// request must be known as well.
static const char request_rules[FUNCTIONS] IN_FLASH = {
    [1] = (char)(IF(FEATURE_BITS) | FIXED(8u)),
    [2] = (char)(IF(FEATURE_BITS) | FIXED(8u)),
    [3] = (char)(SERVED | FIXED(8u)),
    [4] = (char)(SERVED | FIXED(8u)),
    [5] = (char)(IF(FEATURE_BITS) | RULE_BROADCAST | FIXED(8u)),
    [6] = (char)(TO_ALL | FIXED(8u)),
    [7] = (char)FIXED(4u),
    [8] = (char)(IF(FEATURE_DIAGNOSIS) | FIXED(8u)),
    [11] =
        (char)(RULE_BROADCAST | FIXED(4u)), // not served; the bit is for its reply alone
    [12] = (char)FIXED(4u),
    [15] = (char)(IF(FEATURE_BITS) | RULE_BROADCAST | COUNTED(9u, 6u)),
    [16] = (char)(TO_ALL | COUNTED(9u, 6u)),
    [17] = (char)(IF(FEATURE_DIAGNOSIS) | FIXED(4u)),
    [20] = (char)(IF(FEATURE_FILES) | COUNTED(5u, 2u)),
    [21] = (char)COUNTED(5u, 2u),
    [22] = (char)(IF(FEATURE_DIAGNOSIS) | RULE_BROADCAST | FIXED(10u)),
    [23] = (char)(IF(FEATURE_DIAGNOSIS) | COUNTED(13u, 10u)),
    [24] = (char)FIXED(6u),
};

void frame_reset(struct frame *frame)
{
    frame->tried = 0;
}

APART uint8_t frame_rule(uint8_t function)
{
    if (function == IDENTIFICATION) {
        return IF(FEATURE_DIAGNOSIS) | FIXED(7u);
    }
    return function < FUNCTIONS ? (uint8_t)flash_char(&request_rules[function]) : 0;
}

APART uint16_t frame_length_by(const struct frame *frame, uint8_t rule)
{
    uint16_t length = RULE_BYTES(rule);

    return RULE_COUNT(rule) ? (uint16_t)(length + frame->bytes[RULE_AT(rule)]) : length;
}

// The rule of a foreign board's reply, from the rule of its request. A request that may be a
// broadcast is answered by its first 6 bytes and a checksum, any other by counted data.
static uint8_t reply_rule(uint8_t function, uint8_t rule)
{
    if ((function & EXCEPTION) != 0 || function == READ_STATUS) {
        return FIXED(5u);
    }
    return (rule & RULE_BROADCAST) != 0 ? FIXED(8u) : COUNTED(5u, 2u);
}

#if SEVERAL_AXES
#define BYTES_AT_ONCE 96u // some 24 cycles each

static uint16_t checksum(const struct frame *frame, uint16_t length)
{
    const uint8_t *bytes = frame->bytes;
    uint16_t crc = CRC16_START;

    for (; length > BYTES_AT_ONCE; length = (uint16_t)(length - BYTES_AT_ONCE)) {
        crc = crc16_go_on(crc, bytes, BYTES_AT_ONCE);
        bytes += BYTES_AT_ONCE;
        interlude();
    }
    return crc16_go_on(crc, bytes, length);
}
#else
static inline uint16_t checksum(const struct frame *frame, uint16_t length)
{
    return crc16(frame->bytes, length);
}
#endif

// True when a frame of this length is there and its checksum is right.
static APART bool ends_at(struct frame *frame, uint16_t length)
{
    if (length < FRAME_MIN_BYTES || length > frame->received) {
        return false;
    }
    frame->length = length;
    return checksum(frame, length) == 0;
}

// True when a frame by this rule is there. A length that was tried before is not tried again.
static APART bool ends_by(struct frame *frame, uint8_t rule)
{
    uint16_t length = frame_length_by(frame, rule);

    return length > frame->tried && ends_at(frame, length);
}

// True when the frame cannot become longer: a silence has ended it, or it has more bytes than any
// frame may have.
static bool is_over(const struct frame *frame, bool ended)
{
    return ended || frame->received > FRAME_MAX_BYTES;
}

enum frame_status frame_look(struct frame *frame, bool ended, uint8_t address)
{
    uint16_t received = frame->received;

    if (received == 0) {
        return FRAME_PARTIAL;
    }
    uint8_t function = frame->bytes[1];
    uint8_t rule = frame_rule(function);
    bool foreign = frame->bytes[0] != address && frame->bytes[0] != 0;

    // A wrong checksum may just mean a frame of another shape, so that the frame is only bad when
    // nothing more follows.
    if (ends_by(frame, rule) || (foreign && ends_by(frame, reply_rule(function, rule))) ||
        (ended && ends_at(frame, received))) {
        frame_reset(frame);
        return foreign ? FRAME_FOREIGN : FRAME_READY;
    }
    frame->tried = received;
    if (!is_over(frame, ended)) {
        return FRAME_PARTIAL;
    }
    frame->length = received;
    frame_reset(frame);
    return FRAME_BAD;
}

uint16_t frame_seal(struct frame *frame, uint16_t length)
{
    uint16_t crc = checksum(frame, length);

    frame->bytes[length] = (uint8_t)crc;
    frame->bytes[length + 1u] = (uint8_t)(crc >> 8);
    return (uint16_t)(length + 2u);
}
