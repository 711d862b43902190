// SPDX-License-Identifier: MIT
// The checksum of Modbus RTU: reflected polynomial 0xA001, start value 0xFFFF, sent low byte first.
#pragma once

#include <stdint.h>

// Checksum of `length` bytes; 0 over bytes that end with their own checksum.
uint16_t crc16(const uint8_t *bytes, uint16_t length);
