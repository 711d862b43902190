// SPDX-License-Identifier: MIT
// Quotients, checked by the product of quotient and divisor.
#include <stdint.h>

#include "base/divide.h"
#include "fakes/chance.h"
#include "unity.h"

#define ROUNDS 3000u

static const uint16_t divisors[] = {
    1, 2, 3, 0x7F, 0x80, 0xFF, 0x100, 0x7FFF, 0x8000, 0x8001, 0xFFFE, 0xFFFF};

void setUp(void)
{
    chance_seed(0x5EED0003uL);
}

void tearDown(void)
{
}

static void check(uint16_t high, uint16_t low, uint16_t divisor)
{
    uint32_t value = ((uint32_t)high << 16) | low;
    struct quotient quotient = divide_with_rest(high, low, divisor);

    TEST_ASSERT_LESS_THAN_UINT16(divisor, quotient.rest);
    TEST_ASSERT_EQUAL_HEX32(value, (uint32_t)quotient.whole * divisor + quotient.rest);
    TEST_ASSERT_EQUAL_HEX16(quotient.whole, divide_u32_u16(value, divisor));
}

static void extremes(void)
{
    for (uint8_t i = 0; i < (uint8_t)(sizeof divisors / sizeof divisors[0]); i++) {
        uint16_t divisor = divisors[i];
        check(0, 0, divisor);
        check(0, (uint16_t)(divisor - 1u), divisor);
        check(0, divisor, divisor);
        check(0, 0xFFFF, divisor);
        check((uint16_t)(divisor - 1u), 0, divisor);
        check((uint16_t)(divisor - 1u), 0xFFFF, divisor);
        check((uint16_t)(divisor / 2u), 0x8000, divisor);
    }
}

static void random_quotients(void)
{
    for (uint16_t i = 0; i < ROUNDS; i++) {
        uint16_t divisor = (uint16_t)chance_between(1, 0xFFFF);
        uint16_t high = (uint16_t)chance_between(0, (uint32_t)divisor - 1u);
        check(high, (uint16_t)(chance() >> 16), divisor);
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(extremes);
    RUN_TEST(random_quotients);
    return UNITY_END();
}
