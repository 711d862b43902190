// SPDX-License-Identifier: MIT
// Batches of a narrow curve against the same curve taken step by step: intervals in the ring, what
// the interrupt may see, time, what the walk has left.
#include <stdint.h>

#include "steps/curve_batch.h"
#include "steps/walk.h"
#include "stream/stream.h"
#include "unity.h"

#define AT_30_HZ  533333uL // ticks of a pixel
#define AT_100_HZ 160000uL
#define UNTOUCHED 0xFEu
#define MOST      60u // steps of a batch

static struct step_ring ring;
static struct stream stream;
static struct walk walk;
static struct curve single; // the same curve, step by step
static uint16_t numbers;

void setUp(void)
{
    stream = (struct stream){.ring = &ring};
    stream_reset(
        &stream, 250, 0xFFFFF000uL); // slots and end_ticks wrap in the first batches
    walk = (struct walk){.curved = true};
    numbers = 1;
}

void tearDown(void)
{
}

static uint8_t number_below(uint8_t limit)
{
    numbers = (uint16_t)(numbers * 25173u + 13849u);
    return (uint8_t)((uint8_t)(numbers >> 8) % limit);
}

static void start(uint32_t ticks, uint16_t start_speed, uint16_t steps)
{
    curve_start(&walk.steps.curve, ticks, start_speed, steps);
    curve_start(&single, ticks, start_speed, steps);
    walk.until = steps;
    walk.exact_ticks = 0;
    TEST_ASSERT_EQUAL_UINT8(CURVE_FLAT_NARROW, single.kind);
}

// Make a batch and compare. Returns how often the high byte changed between two of its steps.
static uint8_t batch(uint8_t count)
{
    uint8_t slot = stream.head;
    uint8_t changes = 0;
    uint16_t until = walk.until;
    uint32_t end_ticks = stream.end_ticks;
    uint32_t exact_ticks = walk.exact_ticks;
    uint32_t ticks = 0;

    uint8_t behind = (uint8_t)(slot + count);
    ring.high[behind] = UNTOUCHED;
    ring.high[(uint8_t)(behind + 1u)] = UNTOUCHED;
    curve_batch_narrow(&walk, &stream, count);
    for (uint8_t i = 0; i < count; i++, slot++) {
        uint32_t interval = curve_next(&single);
        TEST_ASSERT_EQUAL_UINT32(interval, stream_entry_ticks(&stream, slot));
        if (i != 0 && ring.high[slot] != ring.high[(uint8_t)(slot - 1u)]) {
            changes++;
        }
        ticks += interval;
    }
    TEST_ASSERT_EQUAL_UINT8(slot, stream.head);
    TEST_ASSERT_EQUAL_HEX8(STEP_HIGH_EMPTY, ring.high[slot]);
    TEST_ASSERT_EQUAL_HEX8(UNTOUCHED, ring.high[(uint8_t)(slot + 1u)]);
    TEST_ASSERT_EQUAL_UINT32(end_ticks + ticks, stream.end_ticks);
    TEST_ASSERT_EQUAL_UINT32(exact_ticks + ticks, walk.exact_ticks);
    TEST_ASSERT_EQUAL_UINT16((uint16_t)(until - count), walk.until);
    return changes;
}

// The whole curve in batches of numbers below `most` + 1, as far as it stays narrow. Returns how
// often the high byte changed inside a batch.
static uint16_t run(uint8_t most)
{
    uint16_t changes = 0;

    while (walk.until > most + 1u) {
        uint8_t wanted = (uint8_t)(1u + number_below(most));
        uint8_t count = curve_narrow(&walk.steps.curve, wanted);
        TEST_ASSERT_TRUE(count != 0 && count <= wanted);
        changes = (uint16_t)(changes + batch(count));
    }
    return changes;
}

// Intervals from 780 down to 762 ticks, across a high byte, and up again.
static void across_a_high_byte(void)
{
    start(AT_30_HZ, 684, 692);
    TEST_ASSERT_TRUE(run(MOST) != 0);
    start(AT_30_HZ, 700, 692);
    TEST_ASSERT_TRUE(run(MOST) != 0);
}

// Up and down, to the highest speed of one axis and beyond.
static void fast_curves(void)
{
    static const uint16_t speeds[] = {300, 700, 900, 1000, 1200};

    for (uint8_t i = 0; i < (uint8_t)(sizeof speeds / sizeof speeds[0]); i++) {
        start(AT_30_HZ, speeds[i], (uint16_t)(speeds[i] + 7u));
        (void)run(MOST);
        start(AT_30_HZ, speeds[i], (uint16_t)(speeds[i] - 7u));
        (void)run(MOST);
        start(AT_100_HZ, (uint16_t)(2u * speeds[i]), (uint16_t)(2u * speeds[i] + 3u));
        (void)run(MOST);
    }
}

static void batches_of_a_few_steps(void)
{
    start(AT_30_HZ, 684, 692);
    (void)run(1);
    start(AT_30_HZ, 684, 692);
    (void)run(5);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(across_a_high_byte);
    RUN_TEST(fast_curves);
    RUN_TEST(batches_of_a_few_steps);
    return UNITY_END();
}
