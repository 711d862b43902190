// SPDX-License-Identifier: MIT
// The sum of single periods against one period after the other.
#include <stdint.h>

#include "fakes/chance.h"
#include "ring/step_ring.h"
#include "ring/step_ring_sum.h"
#include "unity.h"

#define ROUNDS 400u

static struct step_ring ring;

// Single periods only, of every length.
void setUp(void)
{
    chance_seed(0x5EED0004uL);
    for (uint16_t i = 0; i < STEP_RING_SLOTS; i++) {
        ring.low[i] = (uint8_t)chance();
        ring.high[i] = (uint8_t)chance_between(0, STEP_HIGH_TRAIN - 1u);
    }
}

void tearDown(void)
{
}

static uint32_t one_by_one(uint8_t slot, uint8_t count)
{
    uint32_t sum = 0;

    for (; count != 0; count--) {
        sum += ((uint32_t)ring.high[slot] << 8) + ring.low[slot] + 1u;
        slot++;
    }
    return sum;
}

static void check(uint8_t first, uint8_t stop, uint8_t expected_count)
{
    uint8_t slot = first;
    uint32_t sum = step_ring_sum(&ring, &slot, stop);

    TEST_ASSERT_EQUAL_HEX8((uint8_t)(first + expected_count), slot);
    TEST_ASSERT_EQUAL_HEX32(one_by_one(first, expected_count), sum);
}

static void nothing_to_add(void)
{
    check(0, 0, 0);
    check(255, 255, 0);
    ring.high[7] = STEP_HIGH_EMPTY;
    check(7, 20, 0);
}

// Around the end of the ring, too.
static void up_to_stop(void)
{
    for (uint16_t i = 0; i < ROUNDS; i++) {
        uint8_t first = (uint8_t)chance();
        uint8_t count = (uint8_t)chance();
        check(first, (uint8_t)(first + count), count);
    }
}

static void longest_periods(void)
{
    for (uint16_t i = 0; i < STEP_RING_SLOTS; i++) {
        ring.low[i] = 0xFF;
        ring.high[i] = STEP_HIGH_TRAIN - 1u;
    }
    check(3, 2, 255);
}

static void up_to_another_kind_of_entry(void)
{
    static const uint8_t kinds[] = {STEP_HIGH_TRAIN, STEP_HIGH_COMMAND, STEP_HIGH_EMPTY};

    for (uint8_t i = 0; i < (uint8_t)(sizeof kinds / sizeof kinds[0]); i++) {
        uint8_t kept = ring.high[5];
        ring.high[5] = kinds[i];
        check(250, 20, 11);
        check(5, 20, 0);
        check(6, 20, 14);
        ring.high[5] = kept;
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(nothing_to_add);
    RUN_TEST(up_to_stop);
    RUN_TEST(longest_periods);
    RUN_TEST(up_to_another_kind_of_entry);
    return UNITY_END();
}
