// SPDX-License-Identifier: MIT
#include <stdint.h>

#include "motion/segment_queue.h"
#include "unity.h"

#define SLOTS 8u

static struct run slots[SLOTS];
static struct run_queue queue;

void setUp(void)
{
    run_queue_init(&queue, slots, SLOTS);
}

void tearDown(void)
{
}

static bool push(int16_t count)
{
    return run_queue_push(&queue, (struct run){count, (uint16_t)(count + 1)});
}

static void check_pop(int16_t count)
{
    struct run run = {0, 0};

    TEST_ASSERT_TRUE(run_queue_pop(&queue, &run));
    TEST_ASSERT_EQUAL_INT16(count, run.count);
    TEST_ASSERT_EQUAL_UINT16(count + 1, run.repeat);
}

static void starts_empty(void)
{
    struct run run = {-5, 5};

    TEST_ASSERT_EQUAL_UINT8(0, run_queue_fill(&queue));
    TEST_ASSERT_EQUAL_UINT8(SLOTS, run_queue_free(&queue));
    TEST_ASSERT_FALSE(run_queue_pop(&queue, &run));
    TEST_ASSERT_FALSE(run_queue_peek(&queue, 0, &run));
    TEST_ASSERT_EQUAL_INT16(-5, run.count);
}

static void first_in_first_out(void)
{
    TEST_ASSERT_TRUE(push(-7));
    TEST_ASSERT_TRUE(push(8));
    TEST_ASSERT_EQUAL_UINT8(2, run_queue_fill(&queue));
    check_pop(-7);
    check_pop(8);
    TEST_ASSERT_EQUAL_UINT8(0, run_queue_fill(&queue));
}

static void full_refuses_and_keeps(void)
{
    for (int16_t i = 0; i < (int16_t)SLOTS; i++) {
        TEST_ASSERT_TRUE(push(i));
    }
    TEST_ASSERT_EQUAL_UINT8(0, run_queue_free(&queue));
    TEST_ASSERT_FALSE(push(99));
    for (int16_t i = 0; i < (int16_t)SLOTS; i++) {
        check_pop(i);
    }
}

static void peek_does_not_take(void)
{
    struct run run = {0, 0};

    (void)push(1);
    (void)push(2);
    TEST_ASSERT_TRUE(run_queue_peek(&queue, 1, &run));
    TEST_ASSERT_EQUAL_INT16(2, run.count);
    TEST_ASSERT_FALSE(run_queue_peek(&queue, 2, &run));
    check_pop(1);
}

static void clear_empties(void)
{
    (void)push(1);
    run_queue_clear(&queue);
    TEST_ASSERT_EQUAL_UINT8(SLOTS, run_queue_free(&queue));
    (void)push(2);
    check_pop(2);
}

// The indices are free running bytes: far more entries than they count.
static void indices_wrap(uint8_t size)
{
    static struct run many[128];

    run_queue_init(&queue, many, size);
    for (int16_t i = 0; i < 700; i++) {
        TEST_ASSERT_TRUE(push(i));
        if (i + 1 >= size) {
            TEST_ASSERT_EQUAL_UINT8(0, run_queue_free(&queue));
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
