// SPDX-License-Identifier: MIT
// Every refusal and every warning, with the pixel it names. Reversals and seeks are in
// test_line_reversals.c.
#include "fakes/worked_example.h"
#include "line_checking.h"

static void worked_example_is_fine(void)
{
    static const uint16_t backlashes[] = {0, 250, 1000};
    struct segment segment;

    for (uint8_t b = 0; b < 3; b++) {
        for (uint8_t i = 0; worked_entry(backlashes[b], i, &segment); i++) {
            taken(segment.count, segment.repeat);
        }
        TEST_ASSERT_EQUAL(LINE_CHECK_OUTSIDE, check.phase);
        TEST_ASSERT_EQUAL(LINE_none, check.warning);
        TEST_ASSERT_EQUAL_UINT32(worked_pixels(backlashes[b]), check.pixel);
    }
}

static void empty_line_is_fine(void)
{
    begin_smooth();
    ends();
    begin_plain();
    ends();
}

static void odd_line_speed(void)
{
    taken((int16_t)SMOOTH, 0);
    refused(LINE_odd_speed, 1, 250, 1001);
}

static void reversal_inside_a_pixel(void)
{
    begin_smooth();
    taken(4, 1);
    refused(LINE_reverses_inside_pixel, 2, 3, 1);
}

static void end_speed_not_zero(void)
{
    begin_smooth();
    taken(4, 1);
    refused(LINE_ends_moving, 2, LINE_MARK_END, 0);
}

static void equal_counts_from_rest_oscillate(void)
{
    begin_smooth();
    refused(LINE_oscillates, 1, 10, 3);
}

static void equal_counts_one_by_one_oscillate(void)
{
    begin_smooth();
    taken(10, 1);
    refused(LINE_oscillates, 2, 10, 1);
}

static void equal_counts_across_segments_oscillate(void)
{
    begin_smooth();
    taken(5, 1);
    taken(10, 4);
    taken(20, 1);
    refused(LINE_oscillates, 7, 20, 2);
}

static void repaired_with_half_a_count(void)
{
    begin_smooth();
    taken(5, 1);
    taken(10, 3);
    taken(5, 1);
    ends();
    TEST_ASSERT_EQUAL(LINE_none, check.warning);
}

static void repaired_with_two_counts(void)
{
    begin_smooth();
    taken(2, 1);
    taken(7, 1);
    taken(10, 1);
    taken(10, 1);
    taken(5, 1);
    ends();
    TEST_ASSERT_EQUAL(LINE_none, check.warning);
}

static void odd_constant_speed_ripples(void)
{
    begin_smooth();
    taken(250, 1);
    taken(750, 1);
    taken(1001, 6);
    TEST_ASSERT_EQUAL(LINE_ripple, check.warning);
    TEST_ASSERT_EQUAL_UINT32(3, warning_pixel);
    TEST_ASSERT_EQUAL_UINT16(1000, check.speed);
}

static void ripple_up_to_two_steps_or_one_percent(void)
{
    begin_smooth();
    taken(2, 4);
    TEST_ASSERT_EQUAL(LINE_ripple, check.warning);
    refused(LINE_oscillates, 5, 3, 2);
    setUp();
    begin_smooth();
    taken(250, 1);
    taken(505, 2);
    TEST_ASSERT_EQUAL(LINE_ripple, check.warning);
    refused(LINE_oscillates, 4, 506, 2);
}

static void backlash_over_speed(void)
{
    taken((int16_t)SMOOTH, 0);
    refused(LINE_backlash_over_speed, 1, 1001, 1000);
}

static void backlash_no_room(void)
{
    begin(SMOOTH, 250, 1000);
    refused(LINE_backlash_no_room, 1, 4, 1);
}

static void backlash_plain(void)
{
    taken((int16_t)PLAIN, 0);
    refused(LINE_backlash_plain, 1, 1, 2);
}

static void line_speed_not_reached(void)
{
    begin(SMOOTH, 2, 10);
    taken(0, 1);
    taken(4, 1);
    taken(6, 1);
    taken(2, 1);
    taken(0, 1);
    refused(LINE_speed_not_reached, 6, LINE_MARK_END, 0);
}

static void line_speed_exceeded(void)
{
    begin(SMOOTH, 2, 10);
    taken(0, 1);
    refused(LINE_speed_not_reached, 2, 6, 1);
}

static void too_fast_plain(void)
{
    begin_plain();
    taken(1333, 1);
    taken(-1, 1);
    refused(LINE_too_fast, 3, -1334, 1);
}

static void too_fast_at_the_end_of_a_pixel(void)
{
    begin_smooth();
    taken(600, 1);
    taken(1266, 1);
    refused(LINE_too_fast, 3, 1334, 1);
}

static void smooth_lines_have_a_limit_of_their_own(void)
{
    limits.smooth_min_interval_ticks = 800;
    begin_plain();
    taken(1333, 1);
    setUp();
    limits.smooth_min_interval_ticks = 800;
    begin_smooth();
    taken(333, 1);
    taken(666, 5);
    refused(LINE_too_fast, 7, 667, 1);
}

static void acceleration_limit(void)
{
    limits.max_acceleration = 10;
    begin_smooth();
    taken(5, 1);
    refused(LINE_acceleration, 2, 16, 1);
}

static void deceleration_limit(void)
{
    limits.max_acceleration = 10;
    begin_smooth();
    taken(5, 1);
    taken(15, 1);
    refused(LINE_acceleration, 3, 14, 1);
}

static void zero_while_moving(void)
{
    begin_smooth();
    taken(0, 3);
    taken(4, 1);
    refused(LINE_zero_while_moving, 5, 0, 1);
}

static void negative_count(void)
{
    begin_smooth();
    refused(LINE_negative_count, 1, -4, 1);
}

static void start_mark_missing(void)
{
    refused(LINE_malformed, 1, 4, 1);
    setUp();
    refused(LINE_malformed, 1, LINE_MARK_END, 0);
    setUp();
    refused(LINE_malformed, 1, LINE_MARK_START, 1);
}

static void unknown_flags(void)
{
    refused(LINE_malformed, 1, (int16_t)(LINE_MARK_START | 0x400), 0);
    setUp();
    refused(LINE_malformed, 1, (int16_t)(LINE_MARK_START | 0x8000u), 0);
}

// The flags that a line keeps of its start mark are at the mark's bits.
static void flags_at_the_bits_of_the_mark(void)
{
    check = (struct line_check){.smooth = true};
    TEST_ASSERT_EQUAL_HEX8(LINE_START_SMOOTH, check.flags);
    check = (struct line_check){.negative = true};
    TEST_ASSERT_EQUAL_HEX8(LINE_START_NEGATIVE, check.flags);
    check = (struct line_check){.seek = true};
    TEST_ASSERT_EQUAL_HEX8(LINE_START_SEEK, check.flags);
    check = (struct line_check){.begun = true, .behind = true};
    TEST_ASSERT_EQUAL_HEX8(LINE_CHECK_BEHIND, check.flags);
}

// A start mark and its parameter, and a divider to come.
static void begin_divided(uint16_t mark)
{
    begin(mark | LINE_START_DIVIDER, 0, 0);
    TEST_ASSERT_EQUAL(LINE_CHECK_DIVIDER, check.phase);
}

// The limits change once more behind the parameter: those of the divided pixels count.
static void divider_behind_the_parameter(void)
{
    begin_divided(PLAIN);
    taken(4, 0);
    TEST_ASSERT_EQUAL_UINT16(4, divider);
    TEST_ASSERT_FALSE(divider_behind);
    TEST_ASSERT_EQUAL(LINE_CHECK_SEGMENTS, check.phase);
    taken(5333, 1);
    refused(LINE_too_fast, 2, 5334, 1);
}

static void divider_of_a_smooth_line(void)
{
    limits.pixel_ticks = 400;
    begin_divided(SMOOTH);
    taken(2, 0);
    taken(1, 1);
    refused(LINE_too_fast, 2, 3, 1);
}

static void divider_must_be_a_mark(void)
{
    divider = 77;
    begin_divided(PLAIN);
    refused(LINE_malformed, 1, 4, 1);
    TEST_ASSERT_EQUAL_UINT16(77, divider);
}

static void divider_that_is_refused(void)
{
    begin_divided(PLAIN);
    refused(LINE_divider, 1, 1000, 0);
}

// The next line says its own, and is known to come behind one with segments, however many lines
// without any lie in between.
static void divider_of_one_line_only(void)
{
    begin_divided(PLAIN);
    taken(4, 0);
    ends();
    begin_divided(PLAIN);
    taken(4, 0);
    TEST_ASSERT_FALSE(divider_behind);
    taken(5, 1);
    ends();
    begin_plain();
    TEST_ASSERT_EQUAL(LINE_CHECK_SEGMENTS, check.phase);
    ends();
    begin_divided(SEEK | LINE_START_OPEN);
    taken(4, 0);
    TEST_ASSERT_TRUE(divider_behind);
    line_check_reset(&check);
    begin_divided(PLAIN);
    taken(4, 0);
    TEST_ASSERT_FALSE(divider_behind);
}

static void mark_inside_a_line(void)
{
    begin_smooth();
    taken(5, 1);
    refused(LINE_malformed, 2, LINE_MARK_START, 0);
    setUp();
    begin_plain();
    refused(LINE_malformed, 1, LINE_MARK_END | LINE_START_SMOOTH, 0);
}

static void out_of_range(void)
{
    limits.min_interval_ticks = 1;
    begin_plain();
    taken(16383, 1);
    refused(LINE_out_of_range, 2, 16384, 1);
    setUp();
    limits.min_interval_ticks = 1;
    begin_plain();
    refused(LINE_out_of_range, 1, INT16_MIN, 1);
    setUp();
    taken((int16_t)SMOOTH, 0);
    refused(LINE_out_of_range, 1, 2, 32768u);
}

static void next_line_starts_without_warning(void)
{
    begin_smooth();
    taken(1, 2);
    ends();
    TEST_ASSERT_EQUAL(LINE_ripple, check.warning);
    begin_smooth();
    TEST_ASSERT_EQUAL(LINE_none, check.warning);
    refused(LINE_negative_count, 1, -1, 1);
}

static void pixels_count_beyond_16_bits(void)
{
    begin_plain();
    taken(1, 65535u);
    taken(2, 65535u);
    refused(LINE_out_of_range, 131071uL, 20000, 1);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(worked_example_is_fine);
    RUN_TEST(empty_line_is_fine);
    RUN_TEST(odd_line_speed);
    RUN_TEST(reversal_inside_a_pixel);
    RUN_TEST(end_speed_not_zero);
    RUN_TEST(equal_counts_from_rest_oscillate);
    RUN_TEST(equal_counts_one_by_one_oscillate);
    RUN_TEST(equal_counts_across_segments_oscillate);
    RUN_TEST(repaired_with_half_a_count);
    RUN_TEST(repaired_with_two_counts);
    RUN_TEST(odd_constant_speed_ripples);
    RUN_TEST(ripple_up_to_two_steps_or_one_percent);
    RUN_TEST(backlash_over_speed);
    RUN_TEST(backlash_no_room);
    RUN_TEST(backlash_plain);
    RUN_TEST(line_speed_not_reached);
    RUN_TEST(line_speed_exceeded);
    RUN_TEST(too_fast_plain);
    RUN_TEST(too_fast_at_the_end_of_a_pixel);
    RUN_TEST(smooth_lines_have_a_limit_of_their_own);
    RUN_TEST(acceleration_limit);
    RUN_TEST(deceleration_limit);
    RUN_TEST(zero_while_moving);
    RUN_TEST(negative_count);
    RUN_TEST(start_mark_missing);
    RUN_TEST(unknown_flags);
    RUN_TEST(flags_at_the_bits_of_the_mark);
    RUN_TEST(divider_behind_the_parameter);
    RUN_TEST(divider_of_a_smooth_line);
    RUN_TEST(divider_must_be_a_mark);
    RUN_TEST(divider_that_is_refused);
    RUN_TEST(divider_of_one_line_only);
    RUN_TEST(mark_inside_a_line);
    RUN_TEST(out_of_range);
    RUN_TEST(next_line_starts_without_warning);
    RUN_TEST(pixels_count_beyond_16_bits);
    return UNITY_END();
}
