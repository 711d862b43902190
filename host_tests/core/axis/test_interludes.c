// SPDX-License-Identifier: MIT
// What becomes of a block when its axis goes on, ends or fails in the middle of the check.
#include <stddef.h>
#include <string.h>

#include "base/interlude.h"
#include "fakes/axis_bench.h"
#include "unity.h"
#include "wire/crc16.h"
#include "wire/frame.h"

#define PLAIN 0x01
#define ZERO  0x38 // the entry of the same count once more

static void (*deed)(void);
static uint16_t interludes;

void interlude(void)
{
    interludes++;
    if (deed != NULL) {
        deed();
    }
}

void setUp(void)
{
    deed = NULL;
    bench_open(1000, 1);
}

void tearDown(void)
{
}

static void begin_line(void)
{
    const uint8_t head[] = {0x80, PLAIN, 0, 0, 0x80, 0, 0, 0};

    TEST_ASSERT_EQUAL(
        BLOCK_TAKEN,
        bench_queue_block(bench.axis.next_block, head, (uint8_t)sizeof head, true));
    interludes = 0;
}

// A block of so many pixels that turn: none of them is easy.
static enum block_result send_turns(uint8_t pixels)
{
    uint8_t bytes[BENCH_BLOCK_MAX];
    uint8_t size = 0;

    for (uint8_t i = 0; i < pixels; i++) {
        uint16_t count = (uint16_t)(i % 2u == 0 ? 5 : -5);
        bytes[size++] = (uint8_t)(0x80u | count >> 8);
        bytes[size++] = (uint8_t)count;
        bytes[size++] = 0;
        bytes[size++] = 1;
    }
    return bench_queue_block(bench.axis.next_block, bytes, size, true);
}

static void long_checks_have_interludes(void)
{
    begin_line();
    TEST_ASSERT_EQUAL(BLOCK_TAKEN, send_turns(3));
    TEST_ASSERT_EQUAL_UINT16(0, interludes);
    TEST_ASSERT_EQUAL(BLOCK_TAKEN, send_turns(40));
    TEST_ASSERT_GREATER_OR_EQUAL_UINT16(9, interludes);
    TEST_ASSERT_EQUAL_UINT16(8u + 43u * 4u, segment_queue_fill(&bench.axis.queue));
}

static void easy_entries_have_interludes(void)
{
    uint8_t bytes[200] = {0x80, 7, 0, 1};

    for (size_t i = 4; i < sizeof bytes; i++) {
        bytes[i] = ZERO;
    }
    begin_line();
    TEST_ASSERT_EQUAL(
        BLOCK_TAKEN,
        bench_queue_block(bench.axis.next_block, bytes, (uint8_t)sizeof bytes, true));
    TEST_ASSERT_GREATER_OR_EQUAL_UINT16(4, interludes);
}

// An entry of four bytes at every place of a block, and entries of one byte on both sides of it.
// What stood behind the block in its buffer before would be good entries, too.
static void entries_at_every_place(void)
{
    for (uint8_t place = 4; place < 120u; place++) {
        for (uint8_t more = 0; more < 40u; more++) {
            uint8_t bytes[200];
            uint8_t size = (uint8_t)(place + 4u + more);

            memset(bytes, ZERO, sizeof bytes);
            memcpy(bytes, (const uint8_t[]){0x80, 7, 0, 1}, 4);
            memcpy(&bytes[place], (const uint8_t[]){0x80, 8, 0, 1}, 4);
            setUp();
            begin_line();
            // The buffer is full of them before.
            TEST_ASSERT_EQUAL(
                BLOCK_TAKEN,
                bench_queue_block(bench.axis.next_block, bytes, sizeof bytes, true));
            setUp();
            begin_line();
            TEST_ASSERT_EQUAL(
                BLOCK_TAKEN, bench_queue_block(bench.axis.next_block, bytes, size, true));
            TEST_ASSERT_EQUAL_UINT32(place - 2u + more, bench.axis.check.pixel);
            TEST_ASSERT_EQUAL_UINT16(8u + size, segment_queue_fill(&bench.axis.queue));
        }
    }
}

static void fail(void)
{
    axis_fail(&bench.axis);
}

static void stop(void)
{
    axis_stop(&bench.axis);
    axis_discard(&bench.axis, bench.axis.feed.stream.head);
}

// The block comes again: then the axis says what it is.
static void check_nothing_queued(void)
{
    uint16_t number = bench.axis.next_block;
    uint16_t fill = segment_queue_fill(&bench.axis.queue);
    struct line_check check = bench.axis.check;

    TEST_ASSERT_EQUAL(BLOCK_FULL, send_turns(40));
    TEST_ASSERT_EQUAL_UINT16(1, interludes);
    TEST_ASSERT_EQUAL_UINT16(number, bench.axis.next_block);
    TEST_ASSERT_LESS_OR_EQUAL_UINT16(fill, segment_queue_fill(&bench.axis.queue));
    TEST_ASSERT_TRUE(bench.axis.check.phase == check.phase ||
                     bench.axis.check.phase == LINE_CHECK_OUTSIDE);
}

static void an_axis_that_fails_takes_no_block(void)
{
    begin_line();
    TEST_ASSERT_EQUAL(BLOCK_TAKEN, bench_queue(5, 30000));
    TEST_ASSERT_EQUAL(BLOCK_TAKEN, bench_queue(LINE_MARK_END, 0));
    TEST_ASSERT_TRUE(axis_arm(&bench.axis, &bench.period));
    begin_line();
    deed = fail;
    check_nothing_queued();
    TEST_ASSERT_EQUAL(AXIS_FAULT, bench.axis.life.state);
    deed = NULL;
    TEST_ASSERT_EQUAL(BLOCK_REFUSED, send_turns(40));
}

static void lines_that_were_discarded_take_no_block(void)
{
    begin_line();
    deed = stop;
    check_nothing_queued();
    TEST_ASSERT_EQUAL(AXIS_EMPTY, bench.axis.life.state);
    TEST_ASSERT_EQUAL_UINT16(0, segment_queue_fill(&bench.axis.queue));
    deed = NULL;
    TEST_ASSERT_EQUAL(BLOCK_REFUSED, send_turns(40)); // no start mark
}

static void checksum_of_a_long_frame(void)
{
    static struct frame frame;

    frame.bytes[0] = 1;
    interludes = 0;
    TEST_ASSERT_EQUAL_UINT16(34, frame_seal(&frame, 32));
    TEST_ASSERT_EQUAL_UINT16(0, interludes);
    TEST_ASSERT_EQUAL_UINT16(252, frame_seal(&frame, 250));
    TEST_ASSERT_EQUAL_UINT16(2, interludes);
    TEST_ASSERT_EQUAL_HEX16(0, crc16(frame.bytes, 252));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(long_checks_have_interludes);
    RUN_TEST(easy_entries_have_interludes);
    RUN_TEST(entries_at_every_place);
    RUN_TEST(an_axis_that_fails_takes_no_block);
    RUN_TEST(lines_that_were_discarded_take_no_block);
    RUN_TEST(checksum_of_a_long_frame);
    return UNITY_END();
}
