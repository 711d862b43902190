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

static void check_product(uint32_t a, uint32_t b, uint32_t divisor)
{
    uint64_t product = (uint64_t)a * b;
    uint32_t rest = 12345;
    uint32_t whole = divide_product(a, b, divisor, &rest);

    if (product >> 32 >= divisor) {
        TEST_ASSERT_EQUAL_HEX32(UINT32_MAX, whole);
        TEST_ASSERT_EQUAL_UINT32(12345, rest);
        return;
    }
    TEST_ASSERT_TRUE(rest < divisor);
    TEST_ASSERT_EQUAL_HEX64(product, (uint64_t)whole * divisor + rest);
}

static void extreme_products(void)
{
    static const uint32_t values[] = {0,
                                      1,
                                      2,
                                      0xFFFF,
                                      0x10000uL,
                                      0x7FFFFFFFuL,
                                      0x80000000uL,
                                      0xFFFFFFFEuL,
                                      0xFFFFFFFFuL};
    uint8_t count = (uint8_t)(sizeof values / sizeof values[0]);

    for (uint8_t i = 0; i < count; i++) {
        for (uint8_t k = 0; k < count; k++) {
            for (uint8_t d = 0; d < count; d++) {
                check_product(values[i], values[k], values[d]);
            }
        }
    }
}

static void random_products(void)
{
    for (uint16_t i = 0; i < ROUNDS; i++) {
        uint32_t a = chance() >> chance_between(0, 31);
        uint32_t b = chance() >> chance_between(0, 31);
        check_product(a, b, chance() >> chance_between(0, 31));
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(extremes);
    RUN_TEST(random_quotients);
    RUN_TEST(extreme_products);
    RUN_TEST(random_products);
    return UNITY_END();
}
