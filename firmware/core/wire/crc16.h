// SPDX-License-Identifier: MIT
// The checksum of Modbus RTU: reflected polynomial 0xA001, start value 0xFFFF, sent low byte first.
// Every frame of the bus and every stored record of settings ends with it.
#pragma once

#include <stdint.h>

// The checksum of no bytes.
#define CRC16_START 0xFFFFu

// The checksum is 0 over bytes that end with their own checksum, low byte first, so that a receiver
// needs no comparison.
//
//     send       crc16(bytes, n) --> bytes[n] low, bytes[n + 1] high
//     receive    crc16(bytes, n + 2) == 0
//
// Each byte's remainder comes from a table of 512 bytes in flash or, on the smaller board, is
// computed, at twice the time. The functions have no state and may be called from any context;
// their time grows with `length`.

// The checksum of some bytes and then of `length` more (0: crc as it is). crc: the checksum of the
// bytes before, CRC16_START for none.
uint16_t crc16_go_on(uint16_t crc, const uint8_t *bytes, uint16_t length);

// The checksum of `length` bytes; of none, CRC16_START.
static inline uint16_t crc16(const uint8_t *bytes, uint16_t length)
{
    return crc16_go_on(CRC16_START, bytes, length);
}
