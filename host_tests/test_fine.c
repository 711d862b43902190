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

static void halves_are_rounded_down(void)
{
    for (uint16_t i = 0; i < TRIALS; i++) {
        struct fine_ticks fine = any();
        uint8_t times = (uint8_t)(i % 20u);
        int64_t value = value_of(&fine);
        int64_t divisor = (int64_t)1 << times;
        int64_t expected = value / divisor;

        if (value < 0 && value % divisor != 0) {
            expected--;
        }
        fine_halve(&fine, times);
        TEST_ASSERT_EQUAL_INT64(expected, value_of(&fine));
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(sums_wrap_at_48_bits);
    RUN_TEST(a_number_is_added_to_itself);
    RUN_TEST(halves_are_rounded_down);
    return UNITY_END();
}
