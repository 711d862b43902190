// SPDX-License-Identifier: MIT
// 40-bit numbers against 64-bit numbers.
#include <stdint.h>

#include "base/wide.h"
#include "fakes/chance.h"
#include "unity.h"

#define ROUNDS 2000u

static const int64_t values[] = {
    0,
    1,
    -1,
    0x7F,
    0x80,
    0xFF,
    0x100,
    -0x100,
    -0x101,
    0xFFFF,
    0x10000,
    0xFFFFFF,
    0x1000000,
    0x7FFFFFFF,
    -0x80000000LL,
    0xFFFFFFFFLL,
    0x100000000LL,
    0x7FFFFFFFFFLL,
    -0x8000000000LL,
    0x5AA5FF0180LL,
    -0x0102030405LL,
};
#define VALUES (uint8_t)(sizeof values / sizeof values[0])

static const uint16_t factors[] = {
    0, 1, 2, 0x7F, 0x80, 0xFF, 0x100, 0x7FFF, 0x8000, 0xFFFF};
#define FACTORS (uint8_t)(sizeof factors / sizeof factors[0])

void setUp(void)
{
    chance_seed(0x5EED0002uL);
}

void tearDown(void)
{
}

// The lowest 40 bits, with sign.
static int64_t modulo(uint64_t value)
{
    return (int64_t)(value << 24) >> 24;
}

static int64_t random_value(void)
{
    return modulo(((uint64_t)chance() << 32) | chance());
}

static void check_sums(int64_t a, int64_t b)
{
    TEST_ASSERT_TRUE(modulo((uint64_t)a + (uint64_t)b) ==
                     wide_to(wide_add(wide_from(a), wide_from(b))));
    TEST_ASSERT_TRUE(modulo((uint64_t)a - (uint64_t)b) ==
                     wide_to(wide_sub(wide_from(a), wide_from(b))));
}

static void check_product(int64_t a, uint16_t factor)
{
    TEST_ASSERT_TRUE(modulo((uint64_t)a * factor) ==
                     wide_to(wide_times(wide_from(a), factor)));
}

static void conversions(void)
{
    for (uint8_t i = 0; i < VALUES; i++) {
        TEST_ASSERT_TRUE(values[i] == wide_to(wide_from(values[i])));
        int32_t low = (int32_t)values[i];
        TEST_ASSERT_TRUE((int64_t)low == wide_to(wide_from_int32(low)));
    }
}

static void sums(void)
{
    for (uint8_t i = 0; i < VALUES; i++) {
        for (uint8_t j = 0; j < VALUES; j++) {
            check_sums(values[i], values[j]);
        }
    }
    for (uint16_t i = 0; i < ROUNDS; i++) {
        int64_t a = random_value();
        check_sums(a, random_value());
    }
}

static void products(void)
{
    for (uint8_t i = 0; i < VALUES; i++) {
        for (uint8_t j = 0; j < FACTORS; j++) {
            check_product(values[i], factors[j]);
        }
    }
    for (uint16_t i = 0; i < ROUNDS; i++) {
        int64_t a = random_value();
        check_product(a, (uint16_t)(chance() >> 16));
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(conversions);
    RUN_TEST(sums);
    RUN_TEST(products);
    return UNITY_END();
}
