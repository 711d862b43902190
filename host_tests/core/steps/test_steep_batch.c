// SPDX-License-Identifier: MIT
// The end of a batch of steep steps, and the state that it leaves for the next batch.
#include <stdint.h>

#include "ring/step_ring.h"
#include "steps/curve_steep.h"
#include "unity.h"

#define COUNT 3u
#define SLOT  254u // the batch wraps

static struct step_ring ring;
static struct curve_steep steep;
static struct curve_made made;

void setUp(void)
{
}

void tearDown(void)
{
}

// Constant speed, so that each step has exactly these ticks; the guess for the first one is off.
static void burst(uint32_t ticks, int32_t miss)
{
    const uint32_t difference = 0x2000000uL;
    uint64_t step = (uint64_t)difference * ticks;

    steep = (struct curve_steep){
        .at = {.slope = wide_from_int32((int32_t)difference),
               .step_low = (uint16_t)step,
               .step = (uint32_t)(step >> 16)},
        .last_ticks = ticks,
        .change = miss,
        .seen = 2,
        .good = true,
    };
    curve_steep_burst(&steep, &ring, SLOT, COUNT, &made);
}

static void check(uint8_t steps, uint16_t ticks)
{
    uint8_t slot = SLOT;

    TEST_ASSERT_EQUAL_UINT8(steps, made.steps);
    TEST_ASSERT_EQUAL_UINT32((uint32_t)ticks * steps, made.ticks);
    TEST_ASSERT_EQUAL_HEX8((uint16_t)(ticks - 1u) >> 8, made.first_high);
    for (uint8_t i = 0; i < steps; i++) {
        TEST_ASSERT_EQUAL_HEX8((uint8_t)(ticks - 1u), ring.low[slot]);
        if (i != 0) {
            TEST_ASSERT_EQUAL_HEX8((uint16_t)(ticks - 1u) >> 8, ring.high[slot]);
        }
        slot++;
    }
    TEST_ASSERT_EQUAL_UINT32(ticks, steep.last_ticks);
}

// The longest interval to extrapolate from, and one tick more.
static void long_intervals(void)
{
    burst(0x8000, 0);
    check(COUNT, 0x8000);
    TEST_ASSERT_TRUE(steep.good);
    burst(0x8001, 0);
    check(1, 0x8001);
    TEST_ASSERT_FALSE(steep.good);
}

// The largest miss with which a batch goes on, and one tick more, both ways.
static void misses(void)
{
    static const int8_t signs[] = {1, -1};

    for (uint8_t i = 0; i < (uint8_t)(sizeof signs / sizeof signs[0]); i++) {
        burst(1000, signs[i] * CURVE_STEEP_MISS_MAX);
        check(COUNT, 1000);
        TEST_ASSERT_TRUE(steep.good);
        burst(1000, signs[i] * (CURVE_STEEP_MISS_MAX + 1));
        check(1, 1000);
        TEST_ASSERT_FALSE(steep.good);
        TEST_ASSERT_EQUAL_INT32(0, steep.change);
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(long_intervals);
    RUN_TEST(misses);
    return UNITY_END();
}
