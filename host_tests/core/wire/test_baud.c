// SPDX-License-Identifier: MIT
// The rate of the bus: every value of the setting against 32-bit arithmetic.
#include <stdint.h>

#include "unity.h"
#include "wire/baud.h"

void setUp(void)
{
}

void tearDown(void)
{
}

static void divisor_is_the_nearest(void)
{
    for (uint32_t baud_100 = 96; baud_100 <= 10000; baud_100++) {
        uint32_t nearest = (2u * (uint32_t)BAUD_CLOCK_100 + baud_100) / (2 * baud_100);

        TEST_ASSERT_EQUAL_UINT32(nearest, baud_divisor((uint16_t)baud_100));
    }
}

// |clock / divisor - rate| at most rate / 40.
static void possible_is_within_a_fortieth(void)
{
    for (uint32_t baud_100 = 96; baud_100 <= 10000; baud_100++) {
        uint32_t made = (uint32_t)baud_divisor((uint16_t)baud_100) * baud_100;
        uint32_t off =
            made > BAUD_CLOCK_100 ? made - BAUD_CLOCK_100 : BAUD_CLOCK_100 - made;

        TEST_ASSERT_EQUAL(40 * off <= made, baud_possible((uint16_t)baud_100));
    }
}

static void usual_rates_are_possible(void)
{
    static const uint16_t possible[] = {
        96, 144, 192, 288, 384, 576, 768, 1152, 2500, 5000};
    static const uint16_t impossible[] = {0, 1, 95, 4608, 9216, 9700, 10001, 65535};

    for (uint8_t i = 0; i < (uint8_t)(sizeof possible / sizeof possible[0]); i++) {
        TEST_ASSERT_TRUE_MESSAGE(baud_possible(possible[i]), "possible");
    }
    for (uint8_t i = 0; i < (uint8_t)(sizeof impossible / sizeof impossible[0]); i++) {
        TEST_ASSERT_FALSE_MESSAGE(baud_possible(impossible[i]), "impossible");
    }
    TEST_ASSERT_EQUAL(BAUD_CLOCK_100 % 10000u == 0, baud_possible(10000));
}

// In fifths of a CPU cycle, of which a microsecond has a 250th of BAUD_CLOCK_100: 49.5 bits up to
// 19200 baud, 1750 us and 11 bits above; at most two counts short.
static void silence_is_the_standards_with_a_character(void)
{
    for (uint16_t divisor = 2; divisor <= baud_divisor(96); divisor++) {
        uint32_t exact = divisor >= baud_divisor(192)
                             ? (uint32_t)1980u * divisor
                             : (uint32_t)7u * BAUD_CLOCK_100 + (uint32_t)440u * divisor;
        uint32_t made = (uint32_t)1280u * baud_silence_counts((baud_counts)divisor);

        TEST_ASSERT_TRUE(made <= exact && made + 2560u > exact);
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(divisor_is_the_nearest);
    RUN_TEST(possible_is_within_a_fortieth);
    RUN_TEST(usual_rates_are_possible);
    RUN_TEST(silence_is_the_standards_with_a_character);
    return UNITY_END();
}
