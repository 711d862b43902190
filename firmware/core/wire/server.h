// SPDX-License-Identifier: MIT
// Modbus server: a request PDU in a frame becomes the reply in the same frame. Functions 01 to 06,
// 08, 15, 16, 17, 22, 23, 43/14 and (SERVER_FILES) 20; checks in the standard's order: function,
// quantity, address, value.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "wire/frame.h" // struct frame

enum modbus_exception {
    MODBUS_OK = 0,
    MODBUS_ILLEGAL_FUNCTION = 1,
    MODBUS_ILLEGAL_ADDRESS = 2,
    MODBUS_ILLEGAL_VALUE = 3,
    MODBUS_DEVICE_FAILURE = 4,
    MODBUS_BUSY = 6,
};

// The functions that read bits.
#define SERVER_COILS    1u
#define SERVER_DISCRETE 2u

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

// The data behind the server; the application supplies these. Addresses 0-based.
bool data_input_mapped(uint16_t address, uint16_t count);
uint16_t data_input(uint16_t address);
bool data_holding_mapped(uint16_t address, uint16_t count);
uint16_t data_holding(uint16_t address);
// All words or none; words are big-endian bytes. Called with a mapped range only.
enum modbus_exception data_write(uint16_t address, uint16_t count, const uint8_t *words);
// Coils or discrete inputs, by the function that reads them: SERVER_COILS, SERVER_DISCRETE.
bool data_bits_mapped(uint16_t address, uint16_t count, uint8_t which);
bool data_bit(uint16_t address, uint8_t which);
// All coils or none; bit 0 of the first byte is the first. Called with a mapped range only.
enum modbus_exception data_write_coils(uint16_t address,
                                       uint16_t count,
                                       const uint8_t *bits);
// Text after the run indicator of function 17, vendor, product code and revision in words divided
// by spaces; at most `room` bytes, returns the number.
uint8_t data_identity(uint8_t *text, uint8_t room);
bool data_running(void);
uint8_t data_server_id(void);
