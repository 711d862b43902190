// SPDX-License-Identifier: MIT
// The hand-coded product against shift and add.
#include <stdint.h>

#include "base/multiply.h"
#include "fakes/chance.h"
#include "unity.h"

#define ROUNDS 3000u

void setUp(void)
{
    chance_seed(0x5EED0001uL);
}

void tearDown(void)
{
}

static uint32_t shift_and_add(uint32_t a, uint32_t b)
{
    uint32_t sum = 0;

    for (; b != 0; b >>= 1) {
        if ((b & 1u) != 0) {
            sum += a;
        }
        a <<= 1;
    }
    return sum;
}

static void check(uint32_t a, uint16_t b)
{
    TEST_ASSERT_EQUAL_HEX32(shift_and_add(a, b), multiply_u32_u16(a, b));
}

static void extremes(void)
{
    static const uint32_t wide[] = {
        0,
        1,
        0xFFu,
        0x100u,
        0xFFFFu,
        0x10000u,
        0xFFFFFFuL,
        0x1000000uL,
        0x7FFFFFFFuL,
        0x80000000uL,
        0xFFFFFFFFuL,
        0x80FF7F01uL,
    };
    static const uint16_t narrow[] = {
        0, 1, 0x7F, 0x80, 0xFF, 0x100, 0x7FFF, 0x8000, 0xFFFF};

    for (uint8_t i = 0; i < (uint8_t)(sizeof wide / sizeof wide[0]); i++) {
        for (uint8_t j = 0; j < (uint8_t)(sizeof narrow / sizeof narrow[0]); j++) {
            check(wide[i], narrow[j]);
        }
    }
}

static void random_products(void)
{
    for (uint16_t i = 0; i < ROUNDS; i++) {
        uint32_t a = chance();
        check(a, (uint16_t)(chance() >> 16));
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(extremes);
    RUN_TEST(random_products);
    return UNITY_END();
}
