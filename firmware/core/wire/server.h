// SPDX-License-Identifier: MIT
// Modbus server: a request PDU in a frame becomes the reply in the same frame. Functions 03, 04, 06
// and 16; with FEATURE_BITS 01, 02, 05, 15; with FEATURE_DIAGNOSIS 08, 17, 22, 23, 43/14; with
// FEATURE_FILES 20. Checks in the standard's order: function, quantity, address, value.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "wire/frame.h" // struct frame

#define SERVER_COUNTERS 8u

// Of the server and its line; they wrap. In the order of function 08, from sub-function 11 on.
struct server_counters {
    union {
        struct {
            uint16_t bus_messages; // frames with a right checksum, for us or not
            uint16_t crc_errors;   // frames dropped for their checksum
            uint16_t exceptions;   // exception replies
            uint16_t frames_ok;    // requests for us or for all
            uint16_t no_replies;   // of these, without a reply
            uint16_t naks;         // always 0
            uint16_t busy_replies; // exceptions 06
            uint16_t rx_overruns;  // bytes lost by the receiver
        };
        uint16_t all[SERVER_COUNTERS];
    };
    bool listen_only; // nothing is executed or answered but function 08, sub-function 1
};

// Serve the ready frame. Returns the bytes of the reply in frame->bytes, to be sealed and sent, or
// 0; the frame is used up. Writes nothing beyond frame->length if the frame is a broadcast. May
// take some hundred microseconds; main loop only.
uint8_t server_serve(struct frame *frame, struct server_counters *counters);
