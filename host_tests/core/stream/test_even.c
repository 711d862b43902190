// SPDX-License-Identifier: MIT
#include <stdint.h>

#include "fakes/chance.h"
#include "stream/even.h"
#include "unity.h"

void setUp(void)
{
    chance_seed(0x5EED0002uL);
}

void tearDown(void)
{
}

// Step j at t = ceil(j * T / n): t * n >= j * T > (t - 1) * n. Excess = t * n - j * T.
static void check_piece(uint32_t ticks, uint16_t steps)
{
    struct even even = {0};
    uint32_t at = 0;
    int64_t excess = 0;

    even_start(&even, ticks, steps);
    for (uint16_t j = 1; j <= steps; j++) {
        uint32_t interval = even_next(&even);
        at += interval;
        excess += (int64_t)interval * steps - (int64_t)ticks;
        if (excess < 0 || excess >= (int64_t)steps) {
            TEST_FAIL();
        }
    }
    TEST_ASSERT_EQUAL_UINT32(ticks, at);
}

static void places_are_ceilings(void)
{
    static const uint16_t places[] = {143, 286, 429, 572, 715, 858, 1000};
    struct even even = {0};
    uint32_t at = 0;

    even_start(&even, 1000, 7);
    for (uint8_t j = 0; j < 7; j++) {
        at += even_next(&even);
        TEST_ASSERT_EQUAL_UINT32(places[j], at);
    }
}

static void one_step_at_the_end(void)
{
    check_piece(1, 1);
    check_piece(533333uL, 1);
    check_piece(0x1000000uL, 1);
}

static void more_steps_than_ticks(void)
{
    check_piece(3, 7);
}

static void most_steps(void)
{
    check_piece(0x1000000uL, 32767);
    check_piece(0xFFFFFFuL, 32767);
    check_piece(32767, 32767);
}

static void pixel_of_the_worked_example(void)
{
    check_piece(533333uL, 1000);
    check_piece(533334uL, 1000);
}

static void random_pieces(void)
{
    for (uint8_t i = 0; i < 60; i++) {
        uint32_t ticks = chance_between(1, 0x1000000uL);
        check_piece(ticks, (uint16_t)chance_between(1, i < 50 ? 400 : 5000));
    }
}

// Whatever stands there from a piece before, or from a curve in the same place.
static void begun_over_anything(void)
{
    for (uint16_t i = 0; i < 4000; i++) {
        uint32_t ticks = chance_between(1, 0x1000000uL);
        uint16_t steps = (uint16_t)chance_between(1, 32767);
        struct even even = {0};

        switch (i % 4u) {
        case 0: // the same piece
            even_start(&even, ticks, steps);
            break;
        case 1: // almost the same
            even_start(&even, ticks + 1u, steps);
            break;
        case 2: // the same product modulo 2^32
            even.base_ticks = ticks / steps + 0x80000000uL;
            even.remainder = (uint16_t)(ticks % steps);
            break;
        default: // too large a remainder
            even.base_ticks = ticks / steps - (ticks < steps ? 0u : 1u);
            even.remainder = (uint16_t)(ticks % steps + steps);
            break;
        }
        even_start(&even, ticks, steps);
        TEST_ASSERT_EQUAL_UINT32(ticks / steps, even.base_ticks);
        TEST_ASSERT_EQUAL_UINT16(ticks % steps, even.remainder);
        TEST_ASSERT_EQUAL_UINT16(steps, even.steps);
        TEST_ASSERT_EQUAL_UINT16(steps - 1u, even.sum);
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(places_are_ceilings);
    RUN_TEST(one_step_at_the_end);
    RUN_TEST(more_steps_than_ticks);
    RUN_TEST(most_steps);
    RUN_TEST(pixel_of_the_worked_example);
    RUN_TEST(random_pieces);
    RUN_TEST(begun_over_anything);
    return UNITY_END();
}
