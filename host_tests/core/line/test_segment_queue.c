// SPDX-License-Identifier: MIT
#include <stdint.h>

#include "cycles.h"
#include "line/segment_queue.h"
#include "unity.h"

#define SLOTS 8u

static uint8_t memory[512];
static struct segment_queue queue;

void setUp(void)
{
    cycles_start();
    segment_queue_init(&queue, memory, 4u * SLOTS);
}

void tearDown(void)
{
}

static bool push(int16_t count)
{
    return segment_queue_push(&queue, (struct segment){count, (uint16_t)(count + 1)});
}

static void check_next(int16_t count, uint16_t repeat)
{
    struct segment segment = {0, 0};

    TEST_ASSERT_TRUE(segment_queue_pop(&queue, &segment));
    TEST_ASSERT_EQUAL_INT16(count, segment.count);
    TEST_ASSERT_EQUAL_UINT16(repeat, segment.repeat);
}

static void check_pop(int16_t count)
{
    check_next(count, (uint16_t)(count + 1));
}

static void starts_empty(void)
{
    struct segment segment = {-5, 5};

    TEST_ASSERT_EQUAL_UINT16(0, segment_queue_fill(&queue));
    TEST_ASSERT_EQUAL_UINT16(4u * SLOTS, segment_queue_free(&queue));
    TEST_ASSERT_EQUAL_UINT16(SLOTS, segment_queue_free_entries(&queue));
    TEST_ASSERT_FALSE(segment_queue_pop(&queue, &segment));
    TEST_ASSERT_EQUAL_UINT16(0, segment_queue_front_word(&queue));
    TEST_ASSERT_EQUAL_INT16(-5, segment.count);
}

static void first_in_first_out(void)
{
    TEST_ASSERT_TRUE(push(-7));
    TEST_ASSERT_TRUE(push(8));
    TEST_ASSERT_EQUAL_UINT16(8, segment_queue_fill(&queue));
    check_pop(-7);
    check_pop(8);
    TEST_ASSERT_EQUAL_UINT16(0, segment_queue_fill(&queue));
}

static void full_refuses_and_keeps(void)
{
    for (int16_t i = 0; i < (int16_t)SLOTS; i++) {
        TEST_ASSERT_TRUE(push(i));
    }
    TEST_ASSERT_EQUAL_UINT16(0, segment_queue_free(&queue));
    TEST_ASSERT_FALSE(push(99));
    for (int16_t i = 0; i < (int16_t)SLOTS; i++) {
        check_pop(i);
    }
}

static void front_word_does_not_take(void)
{
    (void)segment_queue_push(&queue, (struct segment){0x01F1, 0});
    (void)push(2);
    TEST_ASSERT_EQUAL_HEX16(0x01F1, segment_queue_front_word(&queue));
    check_next(0x01F1, 0);
}

static void check_pixels(int16_t count)
{
    struct segment segment;

    TEST_ASSERT_TRUE(segment_queue_pop_pixels(&queue, &segment));
    TEST_ASSERT_EQUAL_INT16(count, segment.count);
}

// Neither a mark nor an empty queue gives pixels.
static void check_no_pixels(void)
{
    struct segment segment;

    TEST_ASSERT_FALSE(segment_queue_pop_pixels(&queue, &segment));
}

static void marks_stay_where_pixels_are_taken(void)
{
    static const uint8_t bytes[] = {0x3A, 0x77, 5, 0, 0x38, 0x80, 2, 0, 0};

    check_no_pixels();
    segment_queue_append(&queue, bytes, sizeof bytes, 0);
    check_pixels(2);
    check_no_pixels();
    TEST_ASSERT_EQUAL_UINT16(8, segment_queue_fill(&queue));
    check_next(7, 0);
    check_pixels(7);
    check_no_pixels();
    check_next(2, 0);
}

static void clear_empties(void)
{
    const uint8_t near = 0x38;

    (void)push(1);
    segment_queue_clear(&queue);
    TEST_ASSERT_EQUAL_UINT16(4u * SLOTS, segment_queue_free(&queue));
    segment_queue_append(&queue, &near, 1, 0);
    check_next(0, 1); // the difference is to nothing, not to what was discarded
}

// The indices are free running words, and the test queues more bytes than a word counts.
static void indices_wrap(uint16_t entries)
{
    segment_queue_init(&queue, memory, (uint16_t)(4u * entries));
    for (uint16_t i = 0; i < 16600u; i++) {
        int16_t count = (int16_t)(i % 16000u);
        TEST_ASSERT_TRUE(push(count));
        if (i + 1u >= entries) {
            TEST_ASSERT_EQUAL_UINT16(0, segment_queue_free(&queue));
            check_pop((int16_t)((i + 1u - entries) % 16000u));
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

static void append(const uint8_t *bytes, uint8_t size)
{
    segment_queue_append(&queue, bytes, size, 0);
}

// Every form of an entry, each at the ends of its range.
static void forms(void)
{
    static const uint8_t bytes[] = {
        0x80, 100,  0,    1,          // in full
        0x38, 0x70, 0x00,             // near: 0, +56, -56
        0x71, 0x7F, 0x76, 0x80,       // short runs: +127, -128
        0x77, 0xFF, 0xFF, 0x77, 1, 0, // runs
        0x7F, 0xFF, 0x78, 0x00,       // wide: +1023, -1024
        0xFF, 0xFE, 0xFF, 0xFF,       // in full, negative
    };

    segment_queue_init(&queue, memory, 64);
    append(bytes, sizeof bytes);
    check_next(100, 1);
    check_next(100, 1);
    check_next(156, 1);
    check_next(100, 1);
    check_next(227, 2);
    check_next(99, 7);
    check_next(98, 255);
    check_next(99, 0);
    check_next(1122, 1);
    check_next(98, 1);
    check_next(-2, 0xFFFF);
    TEST_ASSERT_EQUAL_UINT16(0, segment_queue_fill(&queue));
}

static void sizes_of_entries(void)
{
    for (uint16_t first = 0; first < 256u; first++) {
        uint8_t size = segment_packed_size((uint8_t)first);
        memory[0] = (uint8_t)first;
        struct segment_reader reader = {.bytes = memory, .mask = UINT16_MAX};
        (void)segment_unpack(&reader);
        TEST_ASSERT_EQUAL_UINT16(size, reader.at);
    }
}

static void entries_wrap_inside(void)
{
    static const uint8_t bytes[] = {0x80, 7, 0, 3, 0x80, 9, 1, 0x38};

    segment_queue_init(&queue, memory, 8);
    for (uint8_t i = 0; i < 8; i++) {
        append(&bytes[7], 1);
        check_next((int16_t)(i == 0 ? 0 : 9), 1);
        append(bytes, 7);
        check_next(7, 3);
        append(&bytes[7], 1); // the last byte of the entry in full
        check_next(9, 0x138);
    }
}

// A difference may leave the range of counts: the check refuses the sum.
static void sums_wrap(void)
{
    static const uint8_t bytes[] = {0xBF, 0xFF, 0, 1, 0x7F, 0xFF};

    append(bytes, sizeof bytes);
    check_next(16383, 1);
    check_next(16383 + 1023, 1);
}

static uint16_t pop_cycles(void)
{
    struct segment segment;
    uint16_t start = cycles_now();

    (void)segment_queue_pop(&queue, &segment);
    uint16_t end = cycles_now();
    return (uint16_t)(end - start - (uint16_t)(cycles_now() - end));
}

// Cycles of taking an entry, on a board.
static void budgets(void)
{
    static const uint8_t bytes[] = {0x39, 0x37, 0x7C, 0x99, 0x71, 3, 0x80, 1, 0, 9};

    append(bytes, sizeof bytes);
    TEST_ASSERT_LESS_OR_EQUAL_UINT16(100, pop_cycles());
    TEST_ASSERT_LESS_OR_EQUAL_UINT16(100, pop_cycles());
    TEST_ASSERT_LESS_OR_EQUAL_UINT16(200, pop_cycles());
    TEST_ASSERT_LESS_OR_EQUAL_UINT16(200, pop_cycles());
    TEST_ASSERT_LESS_OR_EQUAL_UINT16(200, pop_cycles());
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(starts_empty);
    RUN_TEST(first_in_first_out);
    RUN_TEST(full_refuses_and_keeps);
    RUN_TEST(front_word_does_not_take);
    RUN_TEST(marks_stay_where_pixels_are_taken);
    RUN_TEST(clear_empties);
    RUN_TEST(smallest_queue_wraps);
    RUN_TEST(largest_queue_wraps);
    RUN_TEST(forms);
    RUN_TEST(sizes_of_entries);
    RUN_TEST(entries_wrap_inside);
    RUN_TEST(sums_wrap);
    RUN_TEST(budgets);
    return UNITY_END();
}
