// SPDX-License-Identifier: MIT
// Frames in the bytes of a bus and the silences between them; the parser looks after every byte.
#include <stdint.h>
#include <string.h>

#include "unity.h"
#include "wire/frame.h"

#define ADDRESS 7u
#define OTHER   8u

static struct frame frame;
static struct frame sent; // under construction
static uint16_t sent_length;

void setUp(void)
{
    frame_reset(&frame);
    frame.received = 0;
}

void tearDown(void)
{
}

static void build(const uint8_t *bytes, uint8_t length)
{
    memcpy(sent.bytes, bytes, length);
    sent_length = frame_seal(&sent, length);
}

static enum frame_status look(void)
{
    return frame_look(&frame, false, ADDRESS);
}

static enum frame_status silence(void)
{
    return frame_look(&frame, true, ADDRESS);
}

static enum frame_status receive(uint16_t first, uint16_t end)
{
    enum frame_status status = FRAME_PARTIAL;

    for (uint16_t i = first; i < end; i++) {
        frame.bytes[frame.received] = sent.bytes[i];
        frame.received++;
        status = look();
        if (i + 1u < end) {
            TEST_ASSERT_EQUAL(FRAME_PARTIAL, status);
        }
    }
    return status;
}

static void check_over(enum frame_status status, const uint8_t *bytes, uint8_t length)
{
    setUp();
    build(bytes, length);
    TEST_ASSERT_EQUAL(status, receive(0, sent_length));
    TEST_ASSERT_EQUAL_UINT16(sent_length, frame.length);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(sent.bytes, frame.bytes, sent_length);
}

// All bytes arrive at once, with others behind them: the frame at the front is found.
static void check_found_before_others(enum frame_status status)
{
    setUp();
    memcpy(frame.bytes, sent.bytes, sent_length);
    memset(&frame.bytes[sent_length], ADDRESS, 20);
    frame.received = (uint16_t)(sent_length + 20u);
    TEST_ASSERT_EQUAL(status, look());
    TEST_ASSERT_EQUAL_UINT16(sent_length, frame.length);
}

static void requests(uint8_t address, enum frame_status status)
{
    static const uint8_t of_8[] = {1, 2, 3, 4, 5, 6, 8};
    static const uint8_t of_4[] = {7, 11, 12, 17};

    for (uint8_t i = 0; i < (uint8_t)(sizeof of_8); i++) {
        const uint8_t request[] = {address, of_8[i], 0, 1, 0, 2};
        check_over(status, request, sizeof request);
        check_found_before_others(status);
    }
    for (uint8_t i = 0; i < (uint8_t)(sizeof of_4); i++) {
        const uint8_t request[] = {address, of_4[i]};
        check_over(status, request, sizeof request);
        check_found_before_others(status);
    }
    check_over(status, (const uint8_t[]){address, 15, 0, 1, 0, 3, 1, 5}, 8);
    check_over(status, (const uint8_t[]){address, 16, 0, 1, 0, 2, 4, 9, 8, 7, 6}, 11);
    check_over(status, (const uint8_t[]){address, 20, 7, 6, 0, 1, 0, 2, 0, 3}, 10);
    check_over(status, (const uint8_t[]){address, 21, 9, 6, 0, 1, 0, 2, 0, 1, 5, 5}, 12);
    check_over(status, (const uint8_t[]){address, 22, 0, 1, 2, 3, 4, 5}, 8);
    check_over(
        status, (const uint8_t[]){address, 23, 0, 1, 0, 2, 0, 3, 0, 1, 2, 9, 8}, 13);
    check_over(status, (const uint8_t[]){address, 24, 0, 1}, 4);
    check_over(status, (const uint8_t[]){address, 43, 14, 1, 0}, 5);
}

static void length_of_requests_is_known(void)
{
    requests(ADDRESS, FRAME_READY);
}

static void requests_to_all_are_ready(void)
{
    requests(0, FRAME_READY);
}

static void requests_to_others_are_foreign(void)
{
    requests(OTHER, FRAME_FOREIGN);
}

static void length_of_foreign_replies_is_known(void)
{
    static const uint8_t counted[] = {1, 2, 3, 4, 12, 17, 20, 21, 23};
    static const uint8_t of_8[] = {5, 6, 8, 11, 15, 16};

    for (uint8_t i = 0; i < (uint8_t)(sizeof counted); i++) {
        const uint8_t odd[] = {OTHER, counted[i], 1, 0x55};
        const uint8_t even[] = {OTHER, counted[i], 6, 1, 2, 3, 4, 5, 6};
        check_over(FRAME_FOREIGN, odd, sizeof odd);
        check_over(FRAME_FOREIGN, even, sizeof even);
        check_found_before_others(FRAME_FOREIGN);
    }
    for (uint8_t i = 0; i < (uint8_t)(sizeof of_8); i++) {
        const uint8_t reply[] = {OTHER, of_8[i], 0x12, 0x34, 0x56, 0x78};
        check_over(FRAME_FOREIGN, reply, sizeof reply);
        check_found_before_others(FRAME_FOREIGN);
    }
    check_over(FRAME_FOREIGN, (const uint8_t[]){OTHER, 7, 0x81}, 3);
    check_over(FRAME_FOREIGN, (const uint8_t[]){OTHER, 22, 0, 1, 2, 3, 4, 5}, 8);
    check_over(FRAME_FOREIGN, (const uint8_t[]){OTHER, 0x83, 2}, 3);
    check_over(FRAME_FOREIGN, (const uint8_t[]){OTHER, 0xAB, 1}, 3);
}

// A reply's length is none of a request's to us.
static void our_request_is_not_cut_where_a_reply_would_end(void)
{
    // The checksum of 07 03 00 in the place of the address' low byte and the count's high one.
    build((const uint8_t[]){ADDRESS, 3, 0}, 3);
    frame.received = 0;
    TEST_ASSERT_EQUAL(FRAME_PARTIAL, receive(0, 5));
    sent.bytes[5] = 1;
    sent_length = frame_seal(&sent, 6);
    TEST_ASSERT_EQUAL(FRAME_READY, receive(5, sent_length));
    TEST_ASSERT_EQUAL_UINT16(8, frame.length);
}

static void unknown_function_ends_with_silence(void)
{
    static const uint8_t functions[] = {0, 9, 25, 65, 127, 0x83, 255};

    for (uint8_t i = 0; i < (uint8_t)(sizeof functions); i++) {
        setUp();
        build((const uint8_t[]){ADDRESS, functions[i], 1, 2, 3}, 5);
        TEST_ASSERT_EQUAL(FRAME_PARTIAL, receive(0, sent_length));
        TEST_ASSERT_EQUAL(FRAME_READY, silence());
        TEST_ASSERT_EQUAL_UINT16(sent_length, frame.length);
    }
    setUp();
    build((const uint8_t[]){OTHER, 43, 14, 1, 0x81, 0, 0, 1, 0, 1, 'x'}, 11);
    TEST_ASSERT_EQUAL(FRAME_PARTIAL, receive(0, sent_length));
    TEST_ASSERT_EQUAL(FRAME_FOREIGN, silence());
    TEST_ASSERT_EQUAL_UINT16(sent_length, frame.length);
}

static void silence_without_bytes_is_nothing(void)
{
    TEST_ASSERT_EQUAL(FRAME_PARTIAL, silence());
    TEST_ASSERT_EQUAL(FRAME_PARTIAL, look());
}

static void bad_checksum_is_bad_at_the_silence(void)
{
    static const uint8_t addresses[] = {0, ADDRESS, OTHER};

    for (uint8_t i = 0; i < (uint8_t)(sizeof addresses); i++) {
        setUp();
        build((const uint8_t[]){addresses[i], 3, 0, 0, 0, 1}, 6);
        sent.bytes[4] ^= 0x10u;
        TEST_ASSERT_EQUAL(FRAME_PARTIAL, receive(0, sent_length));
        TEST_ASSERT_EQUAL(FRAME_BAD, silence());
        TEST_ASSERT_EQUAL_UINT16(sent_length, frame.length);
    }
}

// A known function with another length: the silence tells the length.
static void longer_than_predicted_is_ready_at_the_silence(void)
{
    build((const uint8_t[]){ADDRESS, 3, 0, 0, 0, 1, 99, 98}, 8);
    TEST_ASSERT_EQUAL(FRAME_PARTIAL, receive(0, sent_length));
    TEST_ASSERT_EQUAL(FRAME_READY, silence());
    TEST_ASSERT_EQUAL_UINT16(10, frame.length);
}

static void cut_off_frame_is_bad(void)
{
    for (uint16_t end = 1; end < 8; end++) {
        setUp();
        build((const uint8_t[]){ADDRESS, 3, 0, 0, 0, 1}, 6);
        TEST_ASSERT_EQUAL(FRAME_PARTIAL, receive(0, end));
        TEST_ASSERT_EQUAL(FRAME_BAD, silence());
        TEST_ASSERT_EQUAL_UINT16(end, frame.length);
    }
}

// Two bytes that are the checksum of no bytes, and three bytes that are an address and its
// checksum.
static void too_short_is_bad_whatever_its_checksum(void)
{
    build((const uint8_t[]){ADDRESS}, 0);
    TEST_ASSERT_EQUAL(FRAME_PARTIAL, receive(0, sent_length));
    TEST_ASSERT_EQUAL(FRAME_BAD, silence());
    setUp();
    build((const uint8_t[]){ADDRESS}, 1);
    TEST_ASSERT_EQUAL(FRAME_PARTIAL, receive(0, sent_length));
    TEST_ASSERT_EQUAL(FRAME_BAD, silence());
}

static void longest_frame_is_ready(void)
{
    static uint8_t bytes[FRAME_MAX_BYTES - 2u] = {ADDRESS, 16, 0, 1, 0, 122, 0xF5};

    // 9 + 245 = 254 predicted; two bytes more than that.
    build(bytes, sizeof bytes);
    TEST_ASSERT_EQUAL(FRAME_PARTIAL, receive(0, sent_length));
    TEST_ASSERT_EQUAL(FRAME_READY, silence());
    TEST_ASSERT_EQUAL_UINT16(FRAME_MAX_BYTES, frame.length);
    bytes[6] = 0xF7;
    check_over(FRAME_READY, bytes, sizeof bytes);
    TEST_ASSERT_EQUAL_UINT16(FRAME_MAX_BYTES, frame.length);
}

// The predicted length is longer than the buffer.
static void overlong_frame_is_bad(void)
{
    static uint8_t bytes[FRAME_MAX_BYTES - 2u] = {ADDRESS, 16, 0, 1, 0, 127, 0xFF};

    build(bytes, sizeof bytes);
    sent.bytes[200] ^= 1u;
    TEST_ASSERT_EQUAL(FRAME_PARTIAL, receive(0, FRAME_MAX_BYTES));
    TEST_ASSERT_EQUAL(FRAME_PARTIAL, look());
    TEST_ASSERT_EQUAL(FRAME_BAD, silence());
}

// No frame is this long, and there must be room for the bytes behind it.
static void more_than_a_frame_is_bad_at_once(void)
{
    static uint8_t bytes[FRAME_MAX_BYTES - 2u] = {OTHER, 4, 252};

    build(bytes, sizeof bytes);
    sent.bytes[100] ^= 1u;
    TEST_ASSERT_EQUAL(FRAME_PARTIAL, receive(0, FRAME_MAX_BYTES));
    frame.bytes[FRAME_MAX_BYTES] = 0;
    frame.received = FRAME_MAX_BYTES + 1u;
    TEST_ASSERT_EQUAL(FRAME_BAD, look());
    TEST_ASSERT_EQUAL_UINT16(FRAME_MAX_BYTES + 1u, frame.length);
}

static void next_look_begins_anew(void)
{
    check_over(
        FRAME_FOREIGN, (const uint8_t[]){OTHER, 17, 8, 1, 255, 1, 2, 3, 4, 5, 6}, 11);
    // Without frame_reset(): what was tried before is forgotten.
    frame.received = 0;
    build((const uint8_t[]){ADDRESS, 17}, 2);
    TEST_ASSERT_EQUAL(FRAME_READY, receive(0, sent_length));
    frame.received = 1;
    TEST_ASSERT_EQUAL(FRAME_BAD, silence());
    frame.received = 0;
    TEST_ASSERT_EQUAL(FRAME_READY, receive(0, sent_length));
}

static void seal_appends_low_byte_first(void)
{
    build((const uint8_t[]){1, 3, 0, 0, 0, 0x0A}, 6);
    TEST_ASSERT_EQUAL_UINT16(8, sent_length);
    TEST_ASSERT_EQUAL_HEX8(0xC5, sent.bytes[6]);
    TEST_ASSERT_EQUAL_HEX8(0xCD, sent.bytes[7]);
}

// As on the bus: the bad frame is dropped, and the next frame is already complete, without a
// silence.
static void whole_frame_behind_a_longer_bad_one(void)
{
    static const uint8_t request[] = {ADDRESS, 4, 0, 3, 0, 1};

    memset(frame.bytes, ADDRESS, 40);
    frame.received = 40;
    TEST_ASSERT_EQUAL(FRAME_PARTIAL, look());
    TEST_ASSERT_EQUAL(FRAME_BAD, silence());
    TEST_ASSERT_EQUAL_UINT16(40, frame.length);
    build(request, sizeof request);
    memcpy(frame.bytes, sent.bytes, sent_length);
    frame.received = sent_length;
    TEST_ASSERT_EQUAL(FRAME_READY, look());
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(length_of_requests_is_known);
    RUN_TEST(requests_to_all_are_ready);
    RUN_TEST(requests_to_others_are_foreign);
    RUN_TEST(length_of_foreign_replies_is_known);
    RUN_TEST(our_request_is_not_cut_where_a_reply_would_end);
    RUN_TEST(unknown_function_ends_with_silence);
    RUN_TEST(silence_without_bytes_is_nothing);
    RUN_TEST(bad_checksum_is_bad_at_the_silence);
    RUN_TEST(longer_than_predicted_is_ready_at_the_silence);
    RUN_TEST(cut_off_frame_is_bad);
    RUN_TEST(too_short_is_bad_whatever_its_checksum);
    RUN_TEST(longest_frame_is_ready);
    RUN_TEST(overlong_frame_is_bad);
    RUN_TEST(more_than_a_frame_is_bad_at_once);
    RUN_TEST(next_look_begins_anew);
    RUN_TEST(seal_appends_low_byte_first);
    RUN_TEST(whole_frame_behind_a_longer_bad_one);
    return UNITY_END();
}
