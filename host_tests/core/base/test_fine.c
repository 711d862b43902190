// SPDX-License-Identifier: MIT
#include <stdint.h>

#include "base/fine.h"
#include "fakes/chance.h"
#include "unity.h"

#define TRIALS 2000u

void setUp(void)
{
    chance_seed(1);
}

void tearDown(void)
{
}

static struct fine_ticks any(void)
{
    return (struct fine_ticks){.fraction = (uint16_t)chance(), .ticks = chance()};
}

// The number of 48 bits, with the sign of its highest one.
static int64_t value_of(const struct fine_ticks *fine)
{
    return (int64_t)(int32_t)fine->ticks * 65536 + fine->fraction;
}

static void sums_wrap_at_48_bits(void)
{
    for (uint16_t i = 0; i < TRIALS; i++) {
        struct fine_ticks to = any();
        const struct fine_ticks by = any();
        uint64_t sum = (uint64_t)value_of(&to) + (uint64_t)value_of(&by);

        fine_add(&to, &by);
        TEST_ASSERT_EQUAL_UINT32((uint32_t)(sum >> 16), to.ticks);
        TEST_ASSERT_EQUAL_UINT16((uint16_t)sum, to.fraction);
    }
}

static void a_number_is_added_to_itself(void)
{
    struct fine_ticks fine = {.fraction = 0x9000u, .ticks = 7};

    fine_add(&fine, &fine);
    TEST_ASSERT_EQUAL_UINT32(15, fine.ticks);
    TEST_ASSERT_EQUAL_UINT16(0x2000u, fine.fraction);
}

// Rounded down to a whole number.
static int64_t halved(int64_t value, uint8_t times)
{
    int64_t divisor = (int64_t)1 << times;
    int64_t whole = value / divisor;

    return value < 0 && value % divisor != 0 ? whole - 1 : whole;
}

// Rounded to the nearest one, halves up.
static int64_t halved_nearest(int64_t value, uint8_t times)
{
    return times == 0 ? value : halved(value + ((int64_t)1 << (times - 1u)), times);
}

static void check_number(int64_t expected, const struct fine_ticks *fine)
{
    TEST_ASSERT_EQUAL_UINT32((uint32_t)((uint64_t)expected >> 16), fine->ticks);
    TEST_ASSERT_EQUAL_UINT16((uint16_t)expected, fine->fraction);
}

static void a_pair_is_corrected(void)
{
    for (uint16_t i = 0; i < TRIALS; i++) {
        struct fine_ticks pair[2] = {any(), any()};
        uint8_t shift = (uint8_t)(i % 8u);
        int32_t error_ticks = (int32_t)chance() / 256;
        int64_t error =
            (int64_t)error_ticks * 65536 + FINE_TICK_CENTRE - pair[0].fraction;
        int64_t place = value_of(&pair[0]) + halved_nearest(error, shift);
        uint8_t both = shift == 0 ? 0 : (uint8_t)(2u * shift + 1u);
        int64_t step = value_of(&pair[1]) + halved_nearest(error, both);

        fine_track(pair, error_ticks, shift);
        check_number(place, &pair[0]);
        check_number(step, &pair[1]);
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(sums_wrap_at_48_bits);
    RUN_TEST(a_number_is_added_to_itself);
    RUN_TEST(a_pair_is_corrected);
    return UNITY_END();
}
