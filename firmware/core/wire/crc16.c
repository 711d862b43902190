// SPDX-License-Identifier: MIT
#include "wire/crc16.h"

#include "base/flash.h"     // IN_FLASH_BEHIND
#include "build_features.h" // BOARD_ALL_FEATURES

// What a byte leaves: the parity of the byte contributes 0xC001, and each bit contributes itself
// shifted by 6 and by 7.
#if BOARD_ALL_FEATURES

#define PARITY_4(byte)  ((0x6996u >> ((byte) & 15u)) & 1u)
#define IS_ODD(byte)    (PARITY_4(byte) ^ PARITY_4((byte) >> 4))
#define REMAINDER(byte) (((byte) << 6) ^ ((byte) << 7) ^ (IS_ODD(byte) * 0xC001u))
#define ROW_4(byte)                                                                      \
    REMAINDER(byte), REMAINDER((byte) + 1u), REMAINDER((byte) + 2u),                     \
        REMAINDER((byte) + 3u)
#define ROW_16(byte)                                                                     \
    ROW_4(byte), ROW_4((byte) + 4u), ROW_4((byte) + 8u), ROW_4((byte) + 12u)
#define ROW_64(byte)                                                                     \
    ROW_16(byte), ROW_16((byte) + 16u), ROW_16((byte) + 32u), ROW_16((byte) + 48u)

static const uint16_t remainders[256] IN_FLASH_BEHIND = {
    ROW_64(0u), ROW_64(64u), ROW_64(128u), ROW_64(192u)};

static inline uint16_t byte_remainder(uint8_t byte)
{
    return flash_word(&remainders[byte]);
}

#else

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

#endif

uint16_t crc16_go_on(uint16_t crc, const uint8_t *bytes, uint16_t length)
{
    for (uint16_t i = 0; i < length; i++) {
        crc = (uint16_t)((crc >> 8) ^ byte_remainder((uint8_t)(crc ^ bytes[i])));
    }
    return crc;
}
