// SPDX-License-Identifier: MIT
// Finds the frames of Modbus RTU in the bytes of a line: requests for this board or for all, and
// whatever else goes over the line, requests to other boards and their replies. A frame ends where
// its function says so and its checksum agrees, or with silence. Time is the caller's.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#define FRAME_MAX_BYTES 256u

// Behind a long frame that is looked at late, or a damaged one, there is room for a short one: a
// stop must not be lost.
#define FRAME_ROOM_BYTES (FRAME_MAX_BYTES + 16u)

enum frame_status {
    FRAME_PARTIAL, // nothing yet
    FRAME_READY, // for us or, address 0, for all: bytes[0..length-3] hold address and PDU
    FRAME_FOREIGN, // for somebody else, or from there
    FRAME_BAD,     // ended by silence with a wrong checksum, or too long
};

struct frame {
    uint16_t length;   // of the frame at the front
    uint16_t received; // bytes so far, of this frame and of what follows it
    uint16_t tried;    // no frame ends at so many bytes or before
    uint8_t reply;     // bytes of the reply that the server has made of it
    uint8_t bytes[FRAME_ROOM_BYTES];
};

// Begin anew.
void frame_reset(struct frame *frame);

// Look at the bytes received so far. ended: silence follows them. Unless the answer is
// FRAME_PARTIAL frame->length says how many bytes it is about; the next look is at what follows.
// Takes up to 30 cycles for each byte.
enum frame_status frame_look(struct frame *frame, bool ended, uint8_t address);

// A function's request as frame_rule() knows it.
#define RULE_SERVED    0x40u // by the server
#define RULE_BROADCAST 0x80u // when it goes to all, too

// RULE_* bits of a function's request, and in the rest how its length is found; 0: unknown.
uint8_t frame_rule(uint8_t function);

// Bytes of the frame at the front, if it is such a request; 0 when only silence can tell.
uint16_t frame_length_by(const struct frame *frame, uint8_t rule);

// Append the checksum to `length` bytes; returns the length to send.
uint16_t frame_seal(struct frame *frame, uint16_t length);
