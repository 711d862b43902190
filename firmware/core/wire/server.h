// SPDX-License-Identifier: MIT
// Modbus server: a request PDU in a frame becomes the reply in the same frame. Functions 03, 04,
// 06, 16 and 17; checks in the standard's order: function, quantity, address, value.
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

struct server_counters {
    uint16_t frames_ok;
    uint16_t crc_errors;
    uint16_t exceptions;
};

// Serve the ready frame. Returns the bytes of the reply in frame->bytes, to be sealed and sent; 0
// for a broadcast. May take some hundred microseconds; main loop only.
uint16_t server_serve(struct frame *frame, struct server_counters *counters);

// The data behind the server; the application supplies these. Addresses 0-based.
bool data_input_mapped(uint16_t address, uint16_t count);
uint16_t data_input(uint16_t address);
bool data_holding_mapped(uint16_t address, uint16_t count);
uint16_t data_holding(uint16_t address);
// All words or none; words are big-endian bytes. Called with a mapped range only.
enum modbus_exception data_write(uint16_t address, uint16_t count, const uint8_t *words);
// Text after the run indicator of function 17; at most `room` bytes, returns the number.
uint8_t data_identity(uint8_t *text, uint8_t room);
bool data_running(void);
uint8_t data_server_id(void);
