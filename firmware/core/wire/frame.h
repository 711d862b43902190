// SPDX-License-Identifier: MIT
// Finds the frames of Modbus RTU in the bytes of the bus: requests to this board or to all boards,
// and everything else on the bus, requests to other boards and their replies. A frame ends where
// its function and its checksum agree, or with silence. The caller measures time. Main loop only.
#pragma once

#include <stdbool.h>
#include <stdint.h>

// Longest frame of the standard.
#define FRAME_MAX_BYTES 256u

// Room for a short frame behind a long one that is examined late, or behind a damaged one: a stop
// must not be lost.
#define FRAME_ROOM_BYTES (FRAME_MAX_BYTES + 16u)

enum frame_status {
    // No whole frame yet.
    FRAME_PARTIAL,
    FRAME_READY, // for us or, address 0, for all: bytes[0..length-3] hold address and PDU
    // A request to another board, or a reply of one.
    FRAME_FOREIGN,
    // Ended by silence with a wrong checksum, or too long.
    FRAME_BAD,
};

struct frame {
    // Bytes of the frame at the front.
    uint16_t length;
    // Bytes received so far, of this frame and of what follows it.
    uint16_t received;
    // No frame ends at this many bytes or before.
    uint16_t tried;
    // Bytes of the reply that the server has made of the request.
    uint8_t reply;
    uint8_t bytes[FRAME_ROOM_BYTES];
};

// Begin a new frame.
void frame_reset(struct frame *frame);

// Examine the bytes received so far. ended: silence follows them. Unless the result is
// FRAME_PARTIAL, frame->length is the number of bytes that the result is about; the next call
// examines what follows. Takes up to 30 cycles a byte.
enum frame_status frame_look(struct frame *frame, bool ended, uint8_t address);

// A function's request as frame_rule() knows it.
#define RULE_SERVED    0x40u // by the server
#define RULE_BROADCAST 0x80u // when it goes to all, too

// RULE_* bits of a function's request; the other bits are how its length is found. 0: unknown
// function.
uint8_t frame_rule(uint8_t function);

// Length of the frame at the front if it is such a request; 0 when only silence can end it.
uint16_t frame_length_by(const struct frame *frame, uint8_t rule);

// Append the checksum to `length` bytes. Returns the length to send.
uint16_t frame_seal(struct frame *frame, uint16_t length);
