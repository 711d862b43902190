// SPDX-License-Identifier: MIT
// Receives one Modbus RTU frame, byte by byte. A frame ends when its length is known from its
// function code and reached, or with silence. Time is the caller's: it reports silence as an event.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#define FRAME_MAX_BYTES 256u

enum frame_status {
    FRAME_PARTIAL,
    FRAME_READY, // address and checksum are right: bytes[0..length-3] hold address and PDU
    FRAME_FOREIGN, // for somebody else; the rest up to the next silence is ignored
    FRAME_BAD,     // checksum or length wrong; ignored up to the next silence
};

struct frame {
    uint8_t bytes[FRAME_MAX_BYTES];
    uint16_t length;
    bool ignoring; // up to the next silence
};

void frame_reset(struct frame *frame);

// One byte from the line. address: ours; 0 on the line is broadcast and ready as well.
enum frame_status frame_byte(struct frame *frame, uint8_t byte, uint8_t address);

// The line was silent for 3.5 characters.
enum frame_status frame_silence(struct frame *frame, uint8_t address);

// Append the checksum to `length` bytes; returns the length to send.
uint16_t frame_seal(struct frame *frame, uint16_t length);
