// SPDX-License-Identifier: MIT
// Finds the frames of Modbus RTU in the bytes of the bus: requests to this board or to all boards,
// and everything else on the bus, requests to other boards and their replies. A frame ends where
// its function and its checksum agree, or with silence. The caller measures time. Main loop only.
//
//     uart        bytes arrive in frame->bytes; the caller updates frame->received
//       |
//     frame_look()  --> PARTIAL   wait for more bytes, or for the silence
//                   --> FOREIGN   drop `length` bytes, look again
//                   --> BAD       drop `length` bytes, count an error, look again
//                   --> READY     server_serve(), frame_seal(), send
#pragma once

#include <stdbool.h>
#include <stdint.h>

// Longest frame that the standard allows, bytes, address and checksum included.
#define FRAME_MAX_BYTES 256u

// Size of the buffer. The room beyond the longest frame is for a short frame that follows a long
// frame which is examined late, or a damaged frame: a stop must not be lost. The serial port
// receives straight into this buffer (UART_BUFFER_BYTES in hal/uart.h).
#define FRAME_ROOM_BYTES (FRAME_MAX_BYTES + 16u)

enum frame_status {
    // No whole frame yet: the caller looks again when more bytes or a silence have come.
    FRAME_PARTIAL,
    // A frame for us or, with address 0, for all boards: bytes[0..length-3] hold address and PDU.
    FRAME_READY,
    // A request to another board, or its reply. The frame counts as a message, and is dropped.
    FRAME_FOREIGN,
    // The bytes ended by silence with a wrong checksum, or they are more than any frame has.
    FRAME_BAD,
};

// The one buffer of the bus: it receives requests, and the server writes the reply into it. The
// receive interrupt writes the bytes from bytes[received] on; all else is the main loop's.
struct frame {
    // Bytes of the frame at the front, 1..FRAME_ROOM_BYTES; valid unless frame_look() returned
    // FRAME_PARTIAL. frame_look() writes it.
    uint16_t length;
    // Bytes received so far, of this frame and of what follows it, 0..FRAME_ROOM_BYTES; the caller
    // writes this member.
    uint16_t received;
    // No frame ends at this many bytes or before: these lengths need no second checksum.
    uint16_t tried;
    // Bytes of the reply that the server has made of the request, without the checksum. The server
    // alone uses it.
    uint8_t reply;
    // Address, function, data, checksum (low byte first), and then what follows the frame.
    uint8_t bytes[FRAME_ROOM_BYTES];
};

// Begin a new frame at the front of the buffer; `length` and `received` stay. frame_look() does so
// itself after each frame.
void frame_reset(struct frame *frame);

// Examine the bytes received so far. ended: silence follows them. address: the unit address of this
// board. Unless the result is FRAME_PARTIAL, frame->length is the number of bytes that the result
// is about; the caller drops them, and the next call examines what follows. Takes up to 30 cycles a
// byte; on boards of several axes a long frame brings interludes.
//
// The function code alone does not tell a request from a reply on a shared bus, so that several
// lengths are tried, and the checksum decides.
enum frame_status frame_look(struct frame *frame, bool ended, uint8_t address);

// A bit of a rule: this image's server serves the function.
#define RULE_SERVED 0x40u
// A bit of a rule: a request to address 0, which means all boards, is executed too.
#define RULE_BROADCAST 0x80u

// The rule of a function's requests: RULE_* bits, and in the other bits how the length of the
// request is found. 0: the function is unknown. The rules depend on the features of the image. May
// be called from any context.
uint8_t frame_rule(uint8_t function);

// Length of the frame at the front, checksum included, if the frame is a request with this rule; 0
// when only silence can end it. The result means nothing before the byte that holds the count has
// been received.
uint16_t frame_length_by(const struct frame *frame, uint8_t rule);

// Append the checksum to `length` bytes of the frame. Returns the length to send: `length` + 2. The
// caller makes sure that both bytes fit. On boards of several axes a long frame brings interludes.
uint16_t frame_seal(struct frame *frame, uint16_t length);
