// SPDX-License-Identifier: MIT
// Modbus CRC: reflected polynomial 0xA001, start value 0xFFFF, sent low byte first.
#pragma once

#include <stdint.h>

uint16_t crc16(const uint8_t *bytes, uint16_t length);
