// SPDX-License-Identifier: MIT
// Pieces and expected positions of a line: the anchors of the worked example.
#include <stdbool.h>
#include <stdint.h>

#include "fakes/worked_example.h"
#include "line/line.h"
#include "unity.h"

#define SLOTS    64u
#define TIMER_HZ 16000000uL

static uint8_t slots[4u * SLOTS];
static struct segment_queue queue;
static struct pixel_period period;
static struct line line;
static struct piece piece;
static uint32_t at_ticks; // end of the piece taken last
static uint32_t steps;
static uint16_t edges;

void setUp(void)
{
    segment_queue_init(&queue, slots, sizeof slots);
    (void)pixel_period_set(&period, TIMER_HZ, 30, 1);
    at_ticks = 0;
    steps = 0;
    edges = 0;
}

void tearDown(void)
{
}

static void queue_entry(int16_t count, uint16_t repeat)
{
    TEST_ASSERT_TRUE(segment_queue_push(&queue, (struct segment){count, repeat}));
}

static void queue_worked_example(uint16_t backlash)
{
    struct segment entry;

    for (uint8_t i = 0; worked_entry(backlash, i, &entry); i++) {
        queue_entry(entry.count, entry.repeat);
    }
}

// floor(k * P) at 30 Hz.
static uint32_t edge_place(uint16_t pixel)
{
    return (uint32_t)((uint64_t)TIMER_HZ * pixel / 30u);
}

// The next piece; false at the line's end.
static bool take(void)
{
    if (line_next(&line, &piece) != LINE_PIECE) {
        return false;
    }
    if (piece.has_edge) {
        edges++;
        TEST_ASSERT_EQUAL_UINT32(edge_place(edges), at_ticks + piece.edge_ticks);
        TEST_ASSERT_TRUE(piece.edge_ticks >= 1 && piece.edge_ticks <= piece.ticks);
        TEST_ASSERT_TRUE(piece.edge_steps <= piece.steps);
    }
    at_ticks += piece.ticks;
    steps += piece.steps;
    return true;
}

static void check_worked_example(uint16_t backlash, uint16_t pieces)
{
    uint16_t taken = 0;

    queue_worked_example(backlash);
    line_begin(&line, &period, &queue);
    for (; take(); taken++) {
        if (piece.has_edge) {
            TEST_ASSERT_EQUAL_INT32(worked_position(backlash, edges),
                                    piece.edge_position);
        }
    }
    TEST_ASSERT_EQUAL_UINT16(pieces, taken);
    TEST_ASSERT_EQUAL_UINT16(worked_pixels(backlash), edges);
    TEST_ASSERT_EQUAL_UINT32(edge_place(edges), at_ticks);
    TEST_ASSERT_EQUAL_UINT32(10836uL + backlash, steps);
    TEST_ASSERT_EQUAL_INT32(10836L + backlash, line.position);
}

static void anchors_without_backlash(void)
{
    check_worked_example(0, 32);
}

// There is one piece more than there are pixels: the delay and the take-up share the leading zero
// pixel.
static void anchors_with_backlash_of_a_quarter(void)
{
    check_worked_example(250, 35);
}

static void anchors_with_backlash_of_a_pixel(void)
{
    check_worked_example(1000, 34);
}

static void check_pixel(uint16_t start_speed, bool curved)
{
    TEST_ASSERT_TRUE(take());
    TEST_ASSERT_EQUAL_UINT16(start_speed, piece.start_speed);
    TEST_ASSERT_EQUAL(curved, piece.curved);
}

static void ramp_decodes_to_the_speeds_of_the_profile(void)
{
    static const uint16_t speeds[] = {
        0,
        8,
        16,
        24,
        32,
        38,
        44,
        128,
        172,
        256,
        384,
        512,
        640,
        768,
        896,
    };

    queue_worked_example(0);
    line_begin(&line, &period, &queue);
    for (uint8_t i = 0; i < WORKED_RAMP_PX; i++) {
        check_pixel(speeds[i], true);
    }
    check_pixel(1000, false);
    TEST_ASSERT_EQUAL_UINT16(1000, line.speed);
}

static void delay_before_the_ramp(void)
{
    queue_worked_example(250);
    line_begin(&line, &period, &queue);
    TEST_ASSERT_TRUE(take());
    TEST_ASSERT_EQUAL_UINT32(400000uL, piece.ticks);
    TEST_ASSERT_EQUAL_UINT16(0, piece.steps);
    TEST_ASSERT_FALSE(piece.has_edge);
}

static void take_up_after_the_ramp(void)
{
    queue_worked_example(250);
    line_begin(&line, &period, &queue);
    for (uint8_t i = 0; i < WORKED_RAMP_PX + 2u; i++) {
        (void)take();
    }
    TEST_ASSERT_EQUAL_UINT16(250, piece.steps);
    TEST_ASSERT_FALSE(piece.curved);
    TEST_ASSERT_UINT32_WITHIN(1, 133333uL, piece.ticks);
    TEST_ASSERT_EQUAL_UINT32(edge_place(16), at_ticks);
}

static void no_take_up_leaves_the_zero_pixel_idle(void)
{
    queue_worked_example(250);
    line_begin(&line, &period, &queue);
    line_take_up(&line, 0);
    TEST_ASSERT_TRUE(take());
    TEST_ASSERT_EQUAL_UINT32(533333uL, piece.ticks);
    TEST_ASSERT_EQUAL_UINT16(0, piece.steps);
    while (take()) {
    }
    TEST_ASSERT_EQUAL_UINT32(10836uL, steps);
    TEST_ASSERT_EQUAL_UINT16(34, edges);
}

// Backlash with a fractional pixel period: after the take-up the line is on the clock again.
static void take_up_ends_on_the_clock(uint16_t backlash)
{
    setUp();
    queue_worked_example(backlash);
    line_begin(&line, &period, &queue);
    while (take()) {
    }
    TEST_ASSERT_EQUAL_UINT32(edge_place(34), at_ticks);
    TEST_ASSERT_EQUAL_UINT32(10836uL + backlash, steps);
}

static void every_backlash_ends_on_the_clock(void)
{
    take_up_ends_on_the_clock(1);
    take_up_ends_on_the_clock(333);
    take_up_ends_on_the_clock(500);
    take_up_ends_on_the_clock(999);
}

static void check_negative_pixel(uint16_t start_speed, int32_t position)
{
    TEST_ASSERT_TRUE(take());
    TEST_ASSERT_TRUE(piece.negative);
    TEST_ASSERT_EQUAL_UINT16(start_speed, piece.start_speed);
    TEST_ASSERT_EQUAL_INT32(position, piece.edge_position);
}

static void negative_smooth_line(void)
{
    queue_entry(LINE_MARK_START | LINE_START_SMOOTH | LINE_START_NEGATIVE, 0);
    queue_entry(0, 0);
    queue_entry(4, 2);
    queue_entry(LINE_MARK_END, 0);
    line_begin(&line, &period, &queue);
    check_negative_pixel(0, -4);
    check_negative_pixel(8, -8);
    TEST_ASSERT_FALSE(take());
}

static void plain_line_reverses(void)
{
    queue_entry(LINE_MARK_START, 0);
    queue_entry(0, 0);
    queue_entry(3, 1);
    queue_entry(0, 1);
    queue_entry(-5, 2);
    queue_entry(LINE_MARK_END, 0);
    line_begin(&line, &period, &queue);
    static const int32_t positions[] = {3, 3, -2, -7};
    for (uint8_t i = 0; i < 4; i++) {
        TEST_ASSERT_TRUE(take());
        TEST_ASSERT_FALSE(piece.curved);
        TEST_ASSERT_EQUAL_INT32(positions[i], piece.edge_position);
        TEST_ASSERT_EQUAL(i >= 2, piece.negative);
    }
    TEST_ASSERT_EQUAL(LINE_OVER, line_next(&line, &piece));
}

static void dry_queue_goes_on_when_refilled(void)
{
    queue_entry(LINE_MARK_START, 0);
    queue_entry(0, 0);
    queue_entry(3, 1);
    line_begin(&line, &period, &queue);
    TEST_ASSERT_EQUAL(LINE_PIECE, line_next(&line, &piece));
    TEST_ASSERT_EQUAL(LINE_DRY, line_next(&line, &piece));
    TEST_ASSERT_EQUAL(LINE_DRY, line_next(&line, &piece));
    queue_entry(2, 1);
    TEST_ASSERT_EQUAL(LINE_PIECE, line_next(&line, &piece));
    TEST_ASSERT_EQUAL_INT32(5, piece.edge_position);
}

// 1 2 4 8 8 8 ... down 4 2 1
static void queue_seek(int16_t sign)
{
    static const int16_t up[] = {1, 2, 4};

    queue_entry(LINE_MARK_START | LINE_START_SEEK, 0);
    queue_entry(0, 0);
    for (uint8_t i = 0; i < 3; i++) {
        queue_entry((int16_t)(sign * up[i]), 1);
    }
    queue_entry((int16_t)(sign * 8), 100);
    queue_entry(LINE_MARK_DOWN, 0);
    for (uint8_t i = 3; i-- != 0;) {
        queue_entry((int16_t)(sign * up[i]), 1);
    }
    queue_entry(LINE_MARK_END, 0);
    line_begin(&line, &period, &queue);
}

static void check_counts(const uint16_t *counts, uint8_t length)
{
    for (uint8_t i = 0; i < length; i++) {
        TEST_ASSERT_TRUE(take());
        TEST_ASSERT_EQUAL_UINT16(counts[i], piece.steps);
    }
    TEST_ASSERT_EQUAL(LINE_OVER, line_next(&line, &piece));
}

static void seek_that_never_trips_runs_to_its_end(void)
{
    queue_seek(1);
    while (take()) {
    }
    TEST_ASSERT_EQUAL_INT32(7 + 800 + 7, line.position);
}

static void tripped_seek_slows_down_from_top_speed(void)
{
    static const uint16_t rest[] = {4, 2, 1};

    queue_seek(1);
    for (uint8_t i = 0; i < 10; i++) {
        TEST_ASSERT_TRUE(take());
    }
    segment_source_trip(&line.source);
    check_counts(rest, 3);
    TEST_ASSERT_EQUAL_INT32(7 + 7 * 8 + 7, line.position);
}

static void tripped_seek_slows_down_from_where_it_is(void)
{
    static const uint16_t rest[] = {1};

    queue_seek(-1);
    TEST_ASSERT_TRUE(take());
    TEST_ASSERT_TRUE(take());
    segment_source_trip(&line.source);
    check_counts(rest, 1);
    TEST_ASSERT_EQUAL_INT32(-4, line.position);
}

static void seek_tripped_before_it_begins_makes_no_step(void)
{
    queue_seek(1);
    segment_source_trip(&line.source);
    check_counts(NULL, 0);
}

static void seek_tripped_on_its_way_down_is_left_alone(void)
{
    static const uint16_t rest[] = {2, 1};

    queue_seek(1);
    for (uint8_t i = 0; i < 104; i++) {
        TEST_ASSERT_TRUE(take());
    }
    segment_source_trip(&line.source);
    check_counts(rest, 2);
}

// Speeds 0 8 16 24, held, and mirrored.
static void queue_smooth_seek(void)
{
    static const int16_t up[] = {4, 12, 20};

    queue_entry(LINE_MARK_START | LINE_START_SEEK | LINE_START_SMOOTH, 0);
    queue_entry(0, 0);
    for (uint8_t i = 0; i < 3; i++) {
        queue_entry(up[i], 1);
    }
    queue_entry(24, 100);
    queue_entry(LINE_MARK_DOWN, 0);
    for (uint8_t i = 3; i-- != 0;) {
        queue_entry(up[i], 1);
    }
    queue_entry(LINE_MARK_END, 0);
    line_begin(&line, &period, &queue);
}

static void smooth_seek_stops_behind(uint8_t pixels)
{
    static const uint16_t speeds[] = {0, 8, 16, 24, 24};
    static const uint16_t rest[] = {20, 12, 4};
    uint8_t length = pixels < 3 ? pixels : 3;

    setUp();
    queue_smooth_seek();
    for (uint8_t i = 0; i < pixels; i++) {
        TEST_ASSERT_TRUE(take());
    }
    TEST_ASSERT_EQUAL_UINT16(speeds[pixels], line.speed);
    segment_source_trip(&line.source);
    check_counts(&rest[3u - length], length);
    TEST_ASSERT_EQUAL_UINT16(0, line.speed);
}

static void smooth_seek_stops_from_any_pixel(void)
{
    for (uint8_t pixels = 0; pixels < 5; pixels++) {
        smooth_seek_stops_behind(pixels);
    }
}

// The speeds of this line cannot be made: it runs dry, which is a fault, before the first wrong
// step.
static void smooth_seek_that_is_not_mirrored_runs_dry(void)
{
    queue_entry(LINE_MARK_START | LINE_START_SEEK | LINE_START_SMOOTH, 0);
    queue_entry(0, 0);
    queue_entry(4, 1);
    queue_entry(12, 1);
    queue_entry(16, 100);
    queue_entry(LINE_MARK_DOWN, 0);
    queue_entry(15, 1); // 16 to 14
    queue_entry(7, 1);  // 14 to 0
    queue_entry(LINE_MARK_END, 0);
    line_begin(&line, &period, &queue);
    TEST_ASSERT_TRUE(take());
    segment_source_trip(&line.source); // at speed 8
    TEST_ASSERT_TRUE(take());
    TEST_ASSERT_EQUAL_UINT16(7, piece.steps);
    TEST_ASSERT_EQUAL(LINE_DRY, line_next(&line, &piece));
    TEST_ASSERT_EQUAL(LINE_DRY, line_next(&line, &piece));
}

// A pixel must not end below speed 0: the line runs dry before a wrong step is made.
static void smooth_pixel_too_slow_for_its_speed_runs_dry(void)
{
    queue_entry(LINE_MARK_START | LINE_START_SMOOTH, 0);
    queue_entry(0, 0);
    queue_entry(12, 1); // 0 to 24
    queue_entry(11, 1); // 24 to -2
    line_begin(&line, &period, &queue);
    TEST_ASSERT_TRUE(take());
    TEST_ASSERT_EQUAL(LINE_DRY, line_next(&line, &piece));
    TEST_ASSERT_EQUAL(LINE_DRY, line_next(&line, &piece));
    TEST_ASSERT_EQUAL_INT32(12, line.position);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(anchors_without_backlash);
    RUN_TEST(anchors_with_backlash_of_a_quarter);
    RUN_TEST(anchors_with_backlash_of_a_pixel);
    RUN_TEST(ramp_decodes_to_the_speeds_of_the_profile);
    RUN_TEST(delay_before_the_ramp);
    RUN_TEST(take_up_after_the_ramp);
    RUN_TEST(no_take_up_leaves_the_zero_pixel_idle);
    RUN_TEST(every_backlash_ends_on_the_clock);
    RUN_TEST(negative_smooth_line);
    RUN_TEST(plain_line_reverses);
    RUN_TEST(dry_queue_goes_on_when_refilled);
    RUN_TEST(seek_that_never_trips_runs_to_its_end);
    RUN_TEST(tripped_seek_slows_down_from_top_speed);
    RUN_TEST(tripped_seek_slows_down_from_where_it_is);
    RUN_TEST(seek_tripped_before_it_begins_makes_no_step);
    RUN_TEST(seek_tripped_on_its_way_down_is_left_alone);
    RUN_TEST(smooth_seek_stops_from_any_pixel);
    RUN_TEST(smooth_seek_that_is_not_mirrored_runs_dry);
    RUN_TEST(smooth_pixel_too_slow_for_its_speed_runs_dry);
    return UNITY_END();
}
