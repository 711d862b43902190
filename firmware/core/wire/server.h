// SPDX-License-Identifier: MIT
// Modbus server: a request PDU in a frame becomes the reply in the same frame. Functions 03, 04, 06
// and 16; with FEATURE_BITS 01, 02, 05, 15; with FEATURE_DIAGNOSIS 08, 17, 22, 23, 43/14; with
// FEATURE_FILES 20. Checks in the standard's order: function, quantity, address, value.
//
// The server knows nothing of motors: it asks the functions of server_data.h for the data and
// counts what passed in struct server_counters. Main loop only.
//
//     frame->bytes    | address | function | data ... | checksum |
//     request PDU               |<------------------->|
//     reply           | address | function | data ... |            frame_seal() adds the checksum
//     exception       | address | function + 0x80 | code |
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "build_features.h" // FEATURE_DIAGNOSIS
#include "wire/frame.h"     // struct frame

// Counters that function 08 reads, one by each of its sub-functions from 11 to 18.
#define SERVER_COUNTERS 8u

// What the server and its bus counted since reset or since the counters were cleared; all of them
// wrap. In the order of function 08, from sub-function 11 on. server_serve() counts exceptions,
// requests and replies; the bus port (app/bus) counts the others.
struct server_counters {
    union {
        struct {
            // Frames with a right checksum, for us or not.
            uint16_t bus_messages;
            // Frames dropped for their checksum.
            uint16_t crc_errors;
            // Exception replies.
            uint16_t exceptions;
            // Requests for us or for all.
            uint16_t frames_ok;
            // Those of them that got no reply.
            uint16_t no_replies;
            // Always 0: this server sends no such reply.
            uint16_t naks;
            // Exception replies with code 06.
            uint16_t busy_replies;
            // Bytes lost by the receiver.
            uint16_t rx_overruns;
        };
        // These eight counters by number: all[0] is bus_messages.
        uint16_t all[SERVER_COUNTERS];
    };
    // While it is set, no request is answered, and none but a restart (function 08, sub-function 1)
    // is executed. Sub-function 4 sets it; a restart and a reset of the board clear it.
    bool listen_only;
};

// True in the listen-only mode. An image without function 08 is never in it.
static inline bool server_listens_only(const struct server_counters *counters)
{
    return FEATURE_DIAGNOSIS && counters->listen_only;
}

// Serve the frame for which frame_look() returned FRAME_READY. Returns the number of bytes of the
// reply in frame->bytes, to be sealed and sent. Returns 0 when there is no reply: to a broadcast,
// or in listen-only mode. An exception is a reply of 3 bytes; the request has then changed nothing.
// The request's bytes mean nothing afterwards. If the frame is a broadcast, nothing beyond
// frame->length is written, because the next request may already lie there. May take some hundred
// microseconds; on boards of several axes there may be interludes.
uint8_t server_serve(struct frame *frame, struct server_counters *counters);
