// SPDX-License-Identifier: MIT
#include <stdint.h>

#include "motion/segment_queue.h"
#include "unity.h"

#define SLOTS 8u

static struct segment slots[SLOTS];
static struct segment_queue queue;

void setUp(void)
{
    segment_queue_init(&queue, slots, SLOTS);
}

void tearDown(void)
{
}

static bool push(int16_t count)
{
    return segment_queue_push(&queue, (struct segment){count, (uint16_t)(count + 1)});
}

static void check_pop(int16_t count)
{
    struct segment segment = {0, 0};

    TEST_ASSERT_TRUE(segment_queue_pop(&queue, &segment));
    TEST_ASSERT_EQUAL_INT16(count, segment.count);
    TEST_ASSERT_EQUAL_UINT16(count + 1, segment.repeat);
}

static void starts_empty(void)
{
    struct segment segment = {-5, 5};

    TEST_ASSERT_EQUAL_UINT8(0, segment_queue_fill(&queue));
    TEST_ASSERT_EQUAL_UINT8(SLOTS, segment_queue_free(&queue));
    TEST_ASSERT_FALSE(segment_queue_pop(&queue, &segment));
    TEST_ASSERT_FALSE(segment_queue_peek(&queue, 0, &segment));
    TEST_ASSERT_EQUAL_INT16(-5, segment.count);
}

static void first_in_first_out(void)
{
    TEST_ASSERT_TRUE(push(-7));
    TEST_ASSERT_TRUE(push(8));
    TEST_ASSERT_EQUAL_UINT8(2, segment_queue_fill(&queue));
    check_pop(-7);
    check_pop(8);
    TEST_ASSERT_EQUAL_UINT8(0, segment_queue_fill(&queue));
}

static void full_refuses_and_keeps(void)
{
    for (int16_t i = 0; i < (int16_t)SLOTS; i++) {
        TEST_ASSERT_TRUE(push(i));
    }
    TEST_ASSERT_EQUAL_UINT8(0, segment_queue_free(&queue));
    TEST_ASSERT_FALSE(push(99));
    for (int16_t i = 0; i < (int16_t)SLOTS; i++) {
        check_pop(i);
    }
}

static void peek_does_not_take(void)
{
    struct segment segment = {0, 0};

    (void)push(1);
    (void)push(2);
    TEST_ASSERT_TRUE(segment_queue_peek(&queue, 1, &segment));
    TEST_ASSERT_EQUAL_INT16(2, segment.count);
    TEST_ASSERT_FALSE(segment_queue_peek(&queue, 2, &segment));
    check_pop(1);
}

static void clear_empties(void)
{
    (void)push(1);
    segment_queue_clear(&queue);
    TEST_ASSERT_EQUAL_UINT8(SLOTS, segment_queue_free(&queue));
    (void)push(2);
    check_pop(2);
}

// The indices are free running bytes, so that the test queues far more entries than a byte counts.
static void indices_wrap(uint8_t size)
{
    static struct segment many[128];

    segment_queue_init(&queue, many, size);
    for (int16_t i = 0; i < 700; i++) {
        TEST_ASSERT_TRUE(push(i));
        if (i + 1 >= size) {
            TEST_ASSERT_EQUAL_UINT8(0, segment_queue_free(&queue));
            check_pop((int16_t)(i + 1 - size));
        }
    }
}

static void smallest_queue_wraps(void)
{
    indices_wrap(2);
}

static void largest_queue_wraps(void)
{
    indices_wrap(128);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(starts_empty);
    RUN_TEST(first_in_first_out);
    RUN_TEST(full_refuses_and_keeps);
    RUN_TEST(peek_does_not_take);
    RUN_TEST(clear_empties);
    RUN_TEST(smallest_queue_wraps);
    RUN_TEST(largest_queue_wraps);
    return UNITY_END();
}
