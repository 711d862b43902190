// SPDX-License-Identifier: MIT
// Frames byte by byte, and the silences between them.
#include <stdint.h>
#include <string.h>

#include "unity.h"
#include "wire/frame.h"

#define ADDRESS 7u

static struct frame frame;
static struct frame sent; // request under construction
static uint16_t sent_length;

void setUp(void)
{
    frame_reset(&frame);
}

void tearDown(void)
{
}

static void build(const uint8_t *bytes, uint8_t length)
{
    memcpy(sent.bytes, bytes, length);
    sent_length = frame_seal(&sent, length);
}

static enum frame_status receive(uint16_t first, uint16_t end)
{
    enum frame_status status = FRAME_PARTIAL;

    for (uint16_t i = first; i < end; i++) {
        status = frame_byte(&frame, sent.bytes[i], ADDRESS);
        if (i + 1u < end) {
            TEST_ASSERT_EQUAL(FRAME_PARTIAL, status);
        }
    }
    return status;
}

static void check_ready(const uint8_t *bytes, uint8_t length)
{
    setUp();
    build(bytes, length);
    TEST_ASSERT_EQUAL(FRAME_READY, receive(0, sent_length));
    TEST_ASSERT_EQUAL_UINT16(sent_length, frame.length);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(sent.bytes, frame.bytes, sent_length);
}

static void length_is_known_from_the_function(void)
{
    for (uint8_t function = 3; function <= 6; function++) {
        if (function != 5) {
            const uint8_t request[] = {ADDRESS, function, 0, 1, 0, 2};
            check_ready(request, sizeof request);
        }
    }
    check_ready((const uint8_t[]){ADDRESS, 17}, 2);
}

static void length_is_known_from_the_byte_count(void)
{
    check_ready((const uint8_t[]){ADDRESS, 16, 0, 1, 0, 1, 2, 9, 8}, 9);
    check_ready((const uint8_t[]){ADDRESS, 16, 0, 1, 0, 2, 4, 9, 8, 7, 6}, 11);
}

static void broadcast_is_ready(void)
{
    check_ready((const uint8_t[]){0, 6, 0, 1, 0, 2}, 6);
}

static void unknown_function_ends_with_silence(void)
{
    build((const uint8_t[]){ADDRESS, 43, 14, 1, 0}, 5);
    TEST_ASSERT_EQUAL(FRAME_PARTIAL, receive(0, sent_length));
    TEST_ASSERT_EQUAL(FRAME_READY, frame_silence(&frame, ADDRESS));
    TEST_ASSERT_EQUAL_UINT16(sent_length, frame.length);
}

static void silence_without_bytes_is_nothing(void)
{
    TEST_ASSERT_EQUAL(FRAME_PARTIAL, frame_silence(&frame, ADDRESS));
    TEST_ASSERT_EQUAL(FRAME_PARTIAL, frame_silence(&frame, ADDRESS));
}

static void foreign_frame_is_ignored_up_to_silence(void)
{
    build((const uint8_t[]){ADDRESS + 1u, 3, 0, 0, 0, 1}, 6);
    TEST_ASSERT_EQUAL(FRAME_FOREIGN, frame_byte(&frame, sent.bytes[0], ADDRESS));
    // Even bytes that look like a frame for us.
    build((const uint8_t[]){ADDRESS, 3, 0, 0, 0, 1}, 6);
    TEST_ASSERT_EQUAL(FRAME_PARTIAL, receive(0, sent_length));
    TEST_ASSERT_EQUAL(FRAME_PARTIAL, frame_silence(&frame, ADDRESS));
    TEST_ASSERT_EQUAL(FRAME_READY, receive(0, sent_length));
}

static void bad_checksum_is_bad_at_the_silence(void)
{
    build((const uint8_t[]){ADDRESS, 3, 0, 0, 0, 1}, 6);
    sent.bytes[4] ^= 0x10u;
    TEST_ASSERT_EQUAL(FRAME_PARTIAL, receive(0, sent_length));
    TEST_ASSERT_EQUAL(FRAME_BAD, frame_silence(&frame, ADDRESS));
    sent.bytes[4] ^= 0x10u;
    TEST_ASSERT_EQUAL(FRAME_READY, receive(0, sent_length));
}

// A known function in another shape: its length is found by silence.
static void longer_than_predicted_is_ready_at_the_silence(void)
{
    build((const uint8_t[]){ADDRESS, 3, 0, 0, 0, 1, 99, 98}, 8);
    TEST_ASSERT_EQUAL(FRAME_PARTIAL, receive(0, sent_length));
    TEST_ASSERT_EQUAL(FRAME_READY, frame_silence(&frame, ADDRESS));
    TEST_ASSERT_EQUAL_UINT16(10, frame.length);
}

static void cut_off_frame_is_bad(void)
{
    build((const uint8_t[]){ADDRESS, 3, 0, 0, 0, 1}, 6);
    TEST_ASSERT_EQUAL(FRAME_PARTIAL, receive(0, 5));
    TEST_ASSERT_EQUAL(FRAME_BAD, frame_silence(&frame, ADDRESS));
    TEST_ASSERT_EQUAL(FRAME_READY, receive(0, sent_length));
}

static void single_byte_is_bad(void)
{
    TEST_ASSERT_EQUAL(FRAME_PARTIAL, frame_byte(&frame, ADDRESS, ADDRESS));
    TEST_ASSERT_EQUAL(FRAME_BAD, frame_silence(&frame, ADDRESS));
}

static void longest_frame_is_ready(void)
{
    static uint8_t bytes[FRAME_MAX_BYTES - 2u] = {ADDRESS, 16, 0, 1, 0, 122, 0xF5};

    // 9 + 245 = 254 predicted; two bytes more than that.
    build(bytes, sizeof bytes);
    TEST_ASSERT_EQUAL(FRAME_PARTIAL, receive(0, sent_length));
    TEST_ASSERT_EQUAL(FRAME_READY, frame_silence(&frame, ADDRESS));
}

static void overlong_frame_is_bad_once(void)
{
    for (uint16_t i = 0; i < FRAME_MAX_BYTES; i++) {
        TEST_ASSERT_EQUAL(FRAME_PARTIAL, frame_byte(&frame, ADDRESS, ADDRESS));
    }
    TEST_ASSERT_EQUAL(FRAME_BAD, frame_byte(&frame, 1, ADDRESS));
    TEST_ASSERT_EQUAL(FRAME_PARTIAL, frame_byte(&frame, 2, ADDRESS));
    TEST_ASSERT_EQUAL(FRAME_PARTIAL, frame_silence(&frame, ADDRESS));
    check_ready((const uint8_t[]){ADDRESS, 17}, 2);
}

static void seal_appends_low_byte_first(void)
{
    build((const uint8_t[]){1, 3, 0, 0, 0, 0x0A}, 6);
    TEST_ASSERT_EQUAL_UINT16(8, sent_length);
    TEST_ASSERT_EQUAL_HEX8(0xC5, sent.bytes[6]);
    TEST_ASSERT_EQUAL_HEX8(0xCD, sent.bytes[7]);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(length_is_known_from_the_function);
    RUN_TEST(length_is_known_from_the_byte_count);
    RUN_TEST(broadcast_is_ready);
    RUN_TEST(unknown_function_ends_with_silence);
    RUN_TEST(silence_without_bytes_is_nothing);
    RUN_TEST(foreign_frame_is_ignored_up_to_silence);
    RUN_TEST(bad_checksum_is_bad_at_the_silence);
    RUN_TEST(longer_than_predicted_is_ready_at_the_silence);
    RUN_TEST(cut_off_frame_is_bad);
    RUN_TEST(single_byte_is_bad);
    RUN_TEST(longest_frame_is_ready);
    RUN_TEST(overlong_frame_is_bad_once);
    RUN_TEST(seal_appends_low_byte_first);
    return UNITY_END();
}
