// SPDX-License-Identifier: MIT
// The data behind the Modbus server: what core needs from who links it. The firmware's is
// app/data.c, with app/bits.c and app/identity.c. Addresses are 0-based; main loop only.
#pragma once

#include <stdbool.h>
#include <stdint.h>

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

// Words that may be read together: every one of them is mapped.
bool data_input_mapped(uint16_t address, uint16_t count);
uint16_t data_input(uint16_t address);
bool data_holding_mapped(uint16_t address, uint16_t count);
uint16_t data_holding(uint16_t address);

// Write all words or none; they are big-endian bytes, and have any value afterwards. Called with a
// mapped range only.
enum modbus_exception data_write(uint16_t address, uint16_t count, uint8_t *words);

// Coils or discrete inputs, by the function that reads them: SERVER_COILS, SERVER_DISCRETE.
bool data_bits_mapped(uint16_t address, uint16_t count, uint8_t which);
bool data_bit(uint16_t address, uint8_t which);

// Write all coils or none; bit 0 of the first byte is the first. Called with a mapped range only.
enum modbus_exception data_write_coils(uint16_t address,
                                       uint16_t count,
                                       const uint8_t *bits);

// Text after the run indicator of function 17, vendor, product code and revision in words divided
// by spaces; at most `room` bytes, returns the number.
uint8_t data_identity(uint8_t *text, uint8_t room);
bool data_running(void);
uint8_t data_server_id(void);
