// SPDX-License-Identifier: MIT
#include <stdint.h>

#include "unity.h"
#include "wire/crc16.h"

void setUp(void)
{
}

void tearDown(void)
{
}

static void request_of_the_standard(void)
{
    static const uint8_t request[] = {0x01, 0x03, 0x00, 0x00, 0x00, 0x0A};

    // Low byte first on the line: C5 CD.
    TEST_ASSERT_EQUAL_HEX16(0xCDC5u, crc16(request, sizeof request));
}

static void check_value_of_the_catalogue(void)
{
    TEST_ASSERT_EQUAL_HEX16(0x4B37u, crc16((const uint8_t *)"123456789", 9));
}

static void nothing(void)
{
    TEST_ASSERT_EQUAL_HEX16(0xFFFFu, crc16((const uint8_t *)"", 0));
}

static void sealed_frame_leaves_nothing(void)
{
    static const uint8_t frame[] = {0x01, 0x03, 0x00, 0x00, 0x00, 0x0A, 0xC5, 0xCD};

    TEST_ASSERT_EQUAL_HEX16(0, crc16(frame, sizeof frame));
}

static uint16_t bit_by_bit(const uint8_t *bytes, uint16_t length)
{
    uint16_t crc = 0xFFFFu;

    for (uint16_t i = 0; i < length; i++) {
        crc = (uint16_t)(crc ^ bytes[i]);
        for (uint8_t bit = 0; bit < 8; bit++) {
            crc = (uint16_t)((crc & 1u) != 0 ? (crc >> 1) ^ 0xA001u : crc >> 1);
        }
    }
    return crc;
}

static void every_byte_agrees_with_the_definition(void)
{
    static uint8_t bytes[256];

    for (uint16_t i = 0; i < 256; i++) {
        bytes[i] = (uint8_t)(i * 167u);
        TEST_ASSERT_EQUAL_HEX16(bit_by_bit(&bytes[i], 1), crc16(&bytes[i], 1));
    }
    TEST_ASSERT_EQUAL_HEX16(bit_by_bit(bytes, 256), crc16(bytes, 256));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(request_of_the_standard);
    RUN_TEST(check_value_of_the_catalogue);
    RUN_TEST(nothing);
    RUN_TEST(sealed_frame_leaves_nothing);
    RUN_TEST(every_byte_agrees_with_the_definition);
    return UNITY_END();
}
