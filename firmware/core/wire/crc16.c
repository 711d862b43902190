// SPDX-License-Identifier: MIT
#include "wire/crc16.h"

// Compute what the usual table of 256 entries holds for a byte, because the table would take RAM.
// The parity of the byte contributes 0xC001, and each bit contributes itself shifted by 6 and by 7.
static uint16_t byte_remainder(uint8_t byte)
{
    uint8_t fold = (uint8_t)(byte ^ (byte >> 4));
    // byte << 6, computed as byte << 8 >> 2: two shifts instead of six.
    uint16_t spread = (uint16_t)((uint16_t)byte << 8);

    spread = (uint16_t)(spread >> 1);
    spread = (uint16_t)(spread >> 1);

    fold = (uint8_t)(fold ^ (fold >> 2));
    fold = (uint8_t)(fold ^ (fold >> 1));
    spread = (uint16_t)(spread ^ (spread << 1));
    return (fold & 1u) != 0 ? (uint16_t)(spread ^ 0xC001u) : spread;
}

uint16_t crc16(const uint8_t *bytes, uint16_t length)
{
    uint16_t crc = 0xFFFFu;

    for (uint16_t i = 0; i < length; i++) {
        crc = (uint16_t)((crc >> 8) ^ byte_remainder((uint8_t)(crc ^ bytes[i])));
    }
    return crc;
}
