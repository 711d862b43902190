// SPDX-License-Identifier: MIT
#include "wire/crc16.h"

// Remainders of the sixteen low nibbles: half the table of the usual byte-wise form, and still
// one look-up for four bits.
static const uint16_t nibble_remainder[16] = {
    0x0000,
    0xCC01,
    0xD801,
    0x1400,
    0xF001,
    0x3C00,
    0x2800,
    0xE401,
    0xA001,
    0x6C00,
    0x7800,
    0xB401,
    0x5000,
    0x9C01,
    0x8801,
    0x4400,
};

uint16_t crc16(const uint8_t *bytes, uint16_t length)
{
    uint16_t crc = 0xFFFFu;

    for (uint16_t i = 0; i < length; i++) {
        crc ^= bytes[i];
        crc = (uint16_t)((crc >> 4) ^ nibble_remainder[crc & 0x0Fu]);
        crc = (uint16_t)((crc >> 4) ^ nibble_remainder[crc & 0x0Fu]);
    }
    return crc;
}
