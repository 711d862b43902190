// SPDX-License-Identifier: MIT
// Where a line's segments come from: what is taken, when it is dry or over, what a seek leaves out.
#include <stdbool.h>
#include <stdint.h>

#include "line/segment_source.h"
#include "unity.h"

#define SLOTS 32u
// Start marks of a seek.
#define SEEK        (LINE_MARK_START | LINE_START_SEEK)
#define SMOOTH_SEEK (SEEK | LINE_START_SMOOTH)

static uint8_t memory[4u * SLOTS];
static struct segment_queue queue;
static struct segment_source source;
static struct segment parameter;
// Speed of a line that takes each pixel, as line.c keeps it.
static uint16_t speed;

void setUp(void)
{
    segment_queue_init(&queue, memory, sizeof memory);
    source = (struct segment_source){0};
    speed = 0;
}

void tearDown(void)
{
}

static void queue_entry(uint16_t count, uint16_t repeat)
{
    TEST_ASSERT_TRUE(
        segment_queue_push(&queue, (struct segment){(int16_t)count, repeat}));
}

static void queue_run(int16_t count, uint16_t repeat)
{
    queue_entry((uint16_t)count, repeat);
}

// Begin a line with this start mark and no backlash.
static void begin(uint16_t word)
{
    queue_entry(word, 0);
    queue_entry(0, 0);
    parameter = segment_source_begin(&source, &queue);
}

static void check_segment(int16_t count, uint16_t repeat)
{
    TEST_ASSERT_EQUAL_INT16(count, source.segment.count);
    TEST_ASSERT_EQUAL_UINT16(repeat, source.segment.repeat);
}

static void check_next(int16_t count, uint16_t repeat)
{
    TEST_ASSERT_EQUAL(SEGMENTS_PIXELS, segment_source_next(&source, speed));
    check_segment(count, repeat);
}

static void check_end(enum segments end)
{
    TEST_ASSERT_EQUAL(end, segment_source_next(&source, speed));
}

// Make a pixel of the segment in work: its speed becomes the line's.
static void make_pixel(void)
{
    uint16_t steps = segment_source_steps(&source);

    speed = source.smooth ? (uint16_t)(2u * steps - speed) : steps;
    segment_source_pass_pixel(&source);
}

// Take so many pixels, each of which must be there.
static void take_pixels(uint16_t pixels)
{
    for (uint16_t i = 0; i < pixels; i++) {
        TEST_ASSERT_EQUAL(SEGMENTS_PIXELS, segment_source_next(&source, speed));
        make_pixel();
    }
}

// The pixels that are still to come have these counts, and then the line is over.
static void check_rest(const int16_t *counts, uint8_t length)
{
    for (uint8_t i = 0; i < length; i++) {
        TEST_ASSERT_EQUAL(SEGMENTS_PIXELS, segment_source_next(&source, speed));
        TEST_ASSERT_EQUAL_INT16(counts[i], source.segment.count);
        make_pixel();
    }
    check_end(SEGMENTS_OVER);
}

static void check_flags(bool smooth, bool negative, bool ends_early)
{
    TEST_ASSERT_EQUAL(smooth, source.smooth);
    TEST_ASSERT_EQUAL(negative, source.negative);
    TEST_ASSERT_EQUAL(ends_early, segment_source_ends_early(&source));
    TEST_ASSERT_FALSE(source.leaving_out);
    TEST_ASSERT_FALSE(source.down);
}

static void begins_as(uint16_t flags, bool smooth, bool negative, bool ends_early)
{
    setUp();
    begin((uint16_t)(LINE_MARK_START | flags));
    check_flags(smooth, negative, ends_early);
    check_segment(0, 0);
    TEST_ASSERT_EQUAL_PTR(&queue, source.queue);
    TEST_ASSERT_EQUAL_UINT16(0, segment_queue_fill(&queue));
}

static void head_tells_how_segments_are_read(void)
{
    begins_as(0, false, false, false);
    begins_as(LINE_START_SMOOTH, true, false, false);
    begins_as(LINE_START_SMOOTH | LINE_START_NEGATIVE, true, true, false);
    begins_as(LINE_START_SEEK | LINE_START_OPEN, false, false, true);
    begins_as(LINE_START_WAIT | LINE_START_MORE, false, false, false);
}

static void parameter_is_given_to_the_line(void)
{
    queue_entry(LINE_MARK_START | LINE_START_SMOOTH, 0);
    queue_entry(250, 1000);
    parameter = segment_source_begin(&source, &queue);
    TEST_ASSERT_EQUAL_UINT16(250, (uint16_t)parameter.count & SEGMENT_PARAMETER);
    TEST_ASSERT_EQUAL_UINT16(1000, parameter.repeat);
}

static void divider_is_passed(void)
{
    queue_entry(LINE_MARK_START | LINE_START_DIVIDER, 0);
    queue_entry(0, 0);
    queue_entry(4, 0);
    queue_run(7, 1);
    (void)segment_source_begin(&source, &queue);
    check_next(7, 1);
}

static void line_s_own_flags_are_left_alone(void)
{
    source.edge_open = true;
    begin(LINE_MARK_START);
    TEST_ASSERT_TRUE(source.edge_open);
    TEST_ASSERT_FALSE(source.shifted);
    TEST_ASSERT_FALSE(source.fresh);
}

static void segments_come_in_the_order_of_the_queue(void)
{
    static const int16_t counts[] = {3, 5, 5, -2, 0};

    begin(LINE_MARK_START);
    queue_run(3, 1);
    queue_run(5, 2);
    queue_run(-2, 1);
    queue_run(0, 1);
    queue_entry(LINE_MARK_END, 0);
    check_rest(counts, sizeof counts / sizeof counts[0]);
}

static void segment_in_work_is_kept(void)
{
    begin(LINE_MARK_START);
    queue_run(3, 2);
    queue_run(4, 1);
    check_next(3, 2);
    check_next(3, 2);
    segment_source_pass_pixel(&source);
    check_next(3, 1);
    segment_source_pass_pixel(&source);
    check_next(4, 1);
}

static void steps_have_no_direction(void)
{
    source.segment.count = -16383;
    TEST_ASSERT_EQUAL_UINT16(16383, segment_source_steps(&source));
    source.segment.count = 16383;
    TEST_ASSERT_EQUAL_UINT16(16383, segment_source_steps(&source));
    source.segment.count = 0;
    TEST_ASSERT_EQUAL_UINT16(0, segment_source_steps(&source));
}

static void dry_goes_on_when_more_is_queued(void)
{
    begin(LINE_MARK_START);
    check_end(SEGMENTS_DRY);
    queue_run(3, 1);
    take_pixels(1);
    check_end(SEGMENTS_DRY);
    check_end(SEGMENTS_DRY);
    queue_run(2, 1);
    check_next(2, 1);
}

// What comes after the end belongs to the next line.
static void end_takes_no_more_than_its_mark(void)
{
    begin(LINE_MARK_START);
    queue_run(3, 1);
    queue_entry(LINE_MARK_END, 0);
    queue_entry(LINE_MARK_START, 0);
    take_pixels(1);
    check_end(SEGMENTS_OVER);
    TEST_ASSERT_EQUAL_HEX16(LINE_MARK_START, segment_queue_front_word(&queue));
}

static void smooth_line_ends_at_rest(void)
{
    static const int16_t counts[] = {4, 4};

    begin(LINE_MARK_START | LINE_START_SMOOTH);
    queue_run(4, 2); // 0 to 8, 8 to 0
    queue_entry(LINE_MARK_END, 0);
    check_rest(counts, 2);
}

static void smooth_line_that_ends_with_speed_is_dry(void)
{
    begin(LINE_MARK_START | LINE_START_SMOOTH);
    queue_run(4, 1); // 0 to 8
    queue_entry(LINE_MARK_END, 0);
    take_pixels(1);
    TEST_ASSERT_EQUAL_UINT16(8, speed);
    check_end(SEGMENTS_DRY);
    check_end(SEGMENTS_DRY);
}

static void quick_way_takes_pixels_and_no_mark(void)
{
    begin(LINE_MARK_START);
    segment_source_pixels(&source);
    TEST_ASSERT_EQUAL_UINT16(0, source.segment.repeat);
    queue_run(-3, 2);
    queue_entry(LINE_MARK_END, 0);
    segment_source_pixels(&source);
    check_segment(-3, 2);
    segment_source_pass_pixel(&source);
    segment_source_pass_pixel(&source);
    segment_source_pixels(&source);
    TEST_ASSERT_EQUAL_UINT16(0, source.segment.repeat);
    check_end(SEGMENTS_OVER);
}

static void quick_way_keeps_the_segment_in_work(void)
{
    begin(LINE_MARK_START);
    queue_run(3, 2);
    queue_run(4, 1);
    segment_source_pixels(&source);
    segment_source_pixels(&source);
    check_segment(3, 2);
    segment_source_pass_pixel(&source);
    segment_source_pixels(&source);
    check_segment(3, 1);
}

// 1 2 4 8 8 8 ... down 4 2 1
static void queue_slowdown(int16_t sign)
{
    queue_entry(LINE_MARK_DOWN, 0);
    queue_run((int16_t)(sign * 4), 1);
    queue_run((int16_t)(sign * 2), 1);
    queue_run(sign, 1);
    queue_entry(LINE_MARK_END, 0);
}

static void queue_speed_up(int16_t sign)
{
    queue_run(sign, 1);
    queue_run((int16_t)(sign * 2), 1);
    queue_run((int16_t)(sign * 4), 1);
    queue_run((int16_t)(sign * 8), 5);
}

static void begin_seek(int16_t sign)
{
    begin(SEEK);
    queue_speed_up(sign);
    queue_slowdown(sign);
}

static void seek_that_does_not_trip_leaves_out_nothing(void)
{
    static const int16_t counts[] = {1, 2, 4, 8, 8, 8, 8, 8, 4, 2, 1};

    begin_seek(1);
    check_rest(counts, sizeof counts / sizeof counts[0]);
    TEST_ASSERT_TRUE(source.down);
}

// After `pixels` of a seek, a trip leaves the last `length` pixels of the slowdown.
static void trips_after(uint16_t pixels, int16_t sign, uint8_t length)
{
    int16_t counts[] = {(int16_t)(sign * 4), (int16_t)(sign * 2), sign};

    setUp();
    begin_seek(sign);
    take_pixels(pixels);
    segment_source_trip(&source);
    check_rest(&counts[3u - length], length);
    TEST_ASSERT_EQUAL_UINT16(0, segment_queue_fill(&queue));
}

// A pixel as fast as the last one is no slowdown, so it is left out too.
static void trip_on_the_way_up_leaves_out_to_the_slowdown(void)
{
    trips_after(0, 1, 0);
    trips_after(1, 1, 0);
    trips_after(2, 1, 1);
    trips_after(3, 1, 2);
    trips_after(4, 1, 3);
    trips_after(7, 1, 3);
    trips_after(8, 1, 3);
}

static void direction_does_not_matter(void)
{
    trips_after(2, -1, 1);
    trips_after(5, -1, 3);
}

static void trip_after_the_down_mark_changes_nothing(void)
{
    trips_after(9, 1, 2);
    TEST_ASSERT_FALSE(source.leaving_out);
    trips_after(10, 1, 1);
    trips_after(11, 1, 0);
}

// Of a run on the way down no pixel is left out, though the next one is not slower.
static void trip_after_the_down_mark_keeps_equal_pixels(void)
{
    static const int16_t rest[] = {4, 4, 1};

    begin(SEEK);
    queue_run(8, 1);
    queue_entry(LINE_MARK_DOWN, 0);
    queue_run(4, 3);
    queue_run(1, 1);
    queue_entry(LINE_MARK_END, 0);
    take_pixels(2);
    segment_source_trip(&source);
    check_rest(rest, 3);
}

// A slower pixel before the down mark is not yet the slowdown.
static void slower_pixel_before_the_down_mark_is_left_out(void)
{
    static const int16_t rest[] = {2};

    begin(SEEK);
    queue_run(8, 2);
    queue_run(4, 1);
    queue_run(8, 1);
    queue_entry(LINE_MARK_DOWN, 0);
    queue_run(2, 1);
    queue_entry(LINE_MARK_END, 0);
    take_pixels(1);
    segment_source_trip(&source);
    check_rest(rest, 1);
}

static void second_trip_changes_nothing(void)
{
    static const int16_t rest[] = {2, 1};

    begin_seek(1);
    take_pixels(4);
    segment_source_trip(&source);
    take_pixels(1);
    segment_source_trip(&source);
    check_rest(rest, 2);
}

// The slowdown is not there yet: what comes later is left out as well.
static void leaving_out_goes_on_after_a_dry_queue(void)
{
    static const int16_t rest[] = {4, 2, 1};

    begin(SEEK);
    queue_speed_up(1);
    take_pixels(5);
    segment_source_trip(&source);
    check_end(SEGMENTS_DRY);
    TEST_ASSERT_TRUE(source.leaving_out);
    queue_run(8, 3);
    check_end(SEGMENTS_DRY);
    queue_slowdown(1);
    check_rest(rest, 3);
}

// Speeds 0 8 16 24, held for a while, and mirrored.
static void begin_smooth_seek(void)
{
    begin(SMOOTH_SEEK);
    queue_run(4, 1);
    queue_run(12, 1);
    queue_run(20, 1);
    queue_run(24, 5);
    queue_entry(LINE_MARK_DOWN, 0);
    queue_run(20, 1);
    queue_run(12, 1);
    queue_run(4, 1);
    queue_entry(LINE_MARK_END, 0);
}

static void smooth_seek_trips_after(uint16_t pixels, uint16_t at_speed, uint8_t length)
{
    static const int16_t counts[] = {20, 12, 4};

    setUp();
    begin_smooth_seek();
    take_pixels(pixels);
    TEST_ASSERT_EQUAL_UINT16(at_speed, speed);
    segment_source_trip(&source);
    check_rest(&counts[3u - length], length);
    TEST_ASSERT_EQUAL_UINT16(0, speed);
}

static void smooth_seek_slows_down_from_any_speed(void)
{
    smooth_seek_trips_after(0, 0, 0);
    smooth_seek_trips_after(1, 8, 1);
    smooth_seek_trips_after(2, 16, 2);
    smooth_seek_trips_after(3, 24, 3);
    smooth_seek_trips_after(8, 24, 3);
    smooth_seek_trips_after(9, 16, 2);
}

// Its slowdown is not there: it must not end with a speed.
static void smooth_seek_without_a_slowdown_is_dry(void)
{
    begin(SMOOTH_SEEK);
    queue_run(4, 1); // 0 to 8
    queue_entry(LINE_MARK_DOWN, 0);
    queue_run(8, 1);
    queue_entry(LINE_MARK_END, 0);
    take_pixels(1);
    segment_source_trip(&source);
    check_end(SEGMENTS_DRY);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(head_tells_how_segments_are_read);
    RUN_TEST(parameter_is_given_to_the_line);
    RUN_TEST(divider_is_passed);
    RUN_TEST(line_s_own_flags_are_left_alone);
    RUN_TEST(segments_come_in_the_order_of_the_queue);
    RUN_TEST(segment_in_work_is_kept);
    RUN_TEST(steps_have_no_direction);
    RUN_TEST(dry_goes_on_when_more_is_queued);
    RUN_TEST(end_takes_no_more_than_its_mark);
    RUN_TEST(smooth_line_ends_at_rest);
    RUN_TEST(smooth_line_that_ends_with_speed_is_dry);
    RUN_TEST(quick_way_takes_pixels_and_no_mark);
    RUN_TEST(quick_way_keeps_the_segment_in_work);
    RUN_TEST(seek_that_does_not_trip_leaves_out_nothing);
    RUN_TEST(trip_on_the_way_up_leaves_out_to_the_slowdown);
    RUN_TEST(direction_does_not_matter);
    RUN_TEST(trip_after_the_down_mark_changes_nothing);
    RUN_TEST(trip_after_the_down_mark_keeps_equal_pixels);
    RUN_TEST(slower_pixel_before_the_down_mark_is_left_out);
    RUN_TEST(second_trip_changes_nothing);
    RUN_TEST(leaving_out_goes_on_after_a_dry_queue);
    RUN_TEST(smooth_seek_slows_down_from_any_speed);
    RUN_TEST(smooth_seek_without_a_slowdown_is_dry);
    return UNITY_END();
}
