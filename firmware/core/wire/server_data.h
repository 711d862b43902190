// SPDX-License-Identifier: MIT
// The data that the Modbus server serves: functions that core calls and that the program which
// links core supplies. Those of the firmware are in app/registers. Addresses are 0-based. Main loop
// only.
//
//     core/wire/server.c ---- data_*() ---->  app/registers: data.c, bits.c, identity.c
//
// The server checks a range with the functions *_mapped() first and calls the others with mapped
// addresses only. Reading has no effect on the machine; the first word of a 32-bit value may take
// the sample that the second word completes.
#pragma once

#include <stdbool.h>
#include <stdint.h>

// The exception codes of the standard that this server sends; MODBUS_OK is none of them.
enum modbus_exception {
    // The request was carried out.
    MODBUS_OK = 0,
    // The image does not serve this function, or not this sub-function.
    MODBUS_ILLEGAL_FUNCTION = 1,
    // A register or bit of the range does not exist.
    MODBUS_ILLEGAL_ADDRESS = 2,
    // The quantity, the length or a value is outside its range.
    MODBUS_ILLEGAL_VALUE = 3,
    // The request is well formed, but the board's state does not allow it.
    MODBUS_DEVICE_FAILURE = 4,
    // The board cannot carry the request out yet: the host repeats the request later.
    MODBUS_BUSY = 6,
};

// The functions that read bits: their codes tell the functions below which table is meant.
#define SERVER_COILS    1u
#define SERVER_DISCRETE 2u

// True when every one of the `count` input registers (1..125) from `address` on exists.
bool data_input_mapped(uint16_t address, uint16_t count);
// The value of a mapped input register.
uint16_t data_input(uint16_t address);
// Read the first of these mapped input registers, `count` (1..125) from `address` on, if they take
// less time together than one by one; *to gets them big-endian. Returns how many registers were
// read, 0 when there are none of that kind. There may be an interlude. A board of several axes
// only.
uint8_t data_inputs(uint16_t address, uint8_t count, uint8_t *to);
// True when every one of the `count` holding registers (1..125) from `address` on exists. The queue
// window takes any count at its first address and none elsewhere.
bool data_holding_mapped(uint16_t address, uint16_t count);
// The value of a mapped holding register.
uint16_t data_holding(uint16_t address);

// Write all `count` words from `address` on, or none of them. The words are big-endian bytes; the
// function may use their memory, and they have any value afterwards. Called with a mapped range
// only. Returns MODBUS_OK when everything was written and carried out.
enum modbus_exception data_write(uint16_t address, uint16_t count, uint8_t *words);

// The functions about bits are for images with FEATURE_BITS.

// True when every one of the `count` bits (1..2000) from `address` on exists. which: SERVER_COILS
// or SERVER_DISCRETE.
bool data_bits_mapped(uint16_t address, uint16_t count, uint8_t which);
// The value of a mapped coil or discrete input.
bool data_bit(uint16_t address, uint8_t which);

// Write all `count` coils from `address` on, or none; bit 0 of the first byte is the first coil.
// Two bytes must be readable even when the coils fill only one of them. Called with a mapped range
// only. Returns MODBUS_OK or MODBUS_DEVICE_FAILURE.
enum modbus_exception data_write_coils(uint16_t address,
                                       uint16_t count,
                                       const uint8_t *bits);

// The last three functions are for images with FEATURE_DIAGNOSIS.

// Write the text that identifies the board: vendor, product code and revision, three words divided
// by spaces, without a final zero. At most `room` bytes are written. Returns their number.
uint8_t data_identity(uint8_t *text, uint8_t room);
// The run indicator of function 17: true while an axis runs.
bool data_running(void);
// The server's number in the reply to function 17: the number of the kind of board.
uint8_t data_server_id(void);
