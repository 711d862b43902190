// SPDX-License-Identifier: MIT
#include "wire/frame.h"

#include "wire/crc16.h" // crc16

#define FRAME_MIN_BYTES 4u

void frame_reset(struct frame *frame)
{
    frame->length = 0;
    frame->ignoring = false;
}

// Bytes of a request with this function code; 0 when only silence can tell.
static uint16_t predicted_length(const struct frame *frame)
{
    if (frame->length < 2) {
        return 0;
    }
    switch (frame->bytes[1]) {
    case 3:
    case 4:
    case 6:
        return 8;
    case 16:
        return frame->length < 7 ? 0 : (uint16_t)(9u + frame->bytes[6]);
    case 17:
        return 4;
    default:
        return 0;
    }
}

static enum frame_status judge(const struct frame *frame, uint8_t address)
{
    if (frame->bytes[0] != address && frame->bytes[0] != 0) {
        return FRAME_FOREIGN;
    }
    if (frame->length < FRAME_MIN_BYTES || crc16(frame->bytes, frame->length) != 0) {
        return FRAME_BAD;
    }
    return FRAME_READY;
}

enum frame_status frame_byte(struct frame *frame, uint8_t byte, uint8_t address)
{
    if (frame->ignoring) {
        return FRAME_PARTIAL;
    }
    if (frame->length == FRAME_MAX_BYTES) {
        frame->ignoring = true;
        return FRAME_BAD;
    }
    frame->bytes[frame->length] = byte;
    frame->length++;
    if (frame->bytes[0] != address && frame->bytes[0] != 0) {
        frame->ignoring = true;
        return FRAME_FOREIGN;
    }
    if (frame->length == predicted_length(frame)) {
        enum frame_status status = judge(frame, address);
        // A wrong checksum may only mean a request of another shape: silence decides.
        return status == FRAME_READY ? FRAME_READY : FRAME_PARTIAL;
    }
    return FRAME_PARTIAL;
}

enum frame_status frame_silence(struct frame *frame, uint8_t address)
{
    enum frame_status status = FRAME_PARTIAL;

    if (frame->length != 0 && !frame->ignoring) {
        status = judge(frame, address);
    }
    if (status != FRAME_READY) {
        frame_reset(frame);
    }
    return status;
}

uint16_t frame_seal(struct frame *frame, uint16_t length)
{
    uint16_t crc = crc16(frame->bytes, length);

    frame->bytes[length] = (uint8_t)crc;
    frame->bytes[length + 1u] = (uint8_t)(crc >> 8);
    return (uint16_t)(length + 2u);
}
