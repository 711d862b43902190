// SPDX-License-Identifier: MIT
// The line check at reversals, and in seeks, which may not reverse.
#include "line_checking.h"

static void reversal_too_fast(void)
{
    begin_plain();
    taken(700, 2);
    taken(-320, 1);
    refused(LINE_reversal_too_fast, 4, 321, 1);
}

static void slow_pixel_between_makes_the_reversal_possible(void)
{
    begin_plain();
    taken(700, 2);
    taken(0, 1);
    taken(-700, 1);
    ends();
}

// A rest counts the same whether it is sent in one segment or in parts, and a longer rest never
// counts as a shorter one.
static void rests_add_up(void)
{
    limits.pixel_ticks = 1000;
    begin_plain();
    taken(2, 1);
    taken(0, 1);
    refused(LINE_reversal_too_fast, 3, -2, 1);
    setUp();
    limits.pixel_ticks = 1000;
    begin_plain();
    taken(2, 1);
    taken(0, 1);
    taken(0, 1);
    taken(-2, 1);
    for (uint8_t i = 0; i < 8; i++) {
        taken(0, 8); // 65536 ticks and more together
    }
    taken(0, 2);
    taken(2, 1);
    taken(0, 65535u);
    taken(0, 65535u);
    taken(-2, 1);
    ends();
}

// A chained line follows the line before it without a pause, so that reversals between the two are
// checked too.
static void reversal_into_a_chained_line(void)
{
    begin_plain();
    taken(700, 1);
    ends();
    begin(LINE_MARK_START, 0, 0);
    refused(LINE_reversal_too_fast, 1, -321, 1);
}

static void reversal_into_a_line_that_waits(void)
{
    begin_plain();
    taken(700, 1);
    ends();
    begin_plain();
    taken(-700, 1);
    ends();
}

static void reversal_into_a_chained_smooth_line(void)
{
    limits.pixel_ticks = 160000uL;
    limits.reversal_min_ticks = 40000u;
    begin_plain();
    taken(100, 1);
    ends();
    begin(LINE_MARK_START | LINE_START_SMOOTH | LINE_START_NEGATIVE, 0, 0);
    taken(16, 1); // its first step comes a quarter of a pixel after the start
    setUp();
    limits.pixel_ticks = 160000uL;
    limits.reversal_min_ticks = 40001u;
    begin_plain();
    taken(100, 1);
    ends();
    begin(LINE_MARK_START | LINE_START_SMOOTH | LINE_START_NEGATIVE, 0, 0);
    refused(LINE_reversal_too_fast, 1, 16, 1);
}

// A smooth line begins with a pixel from rest: its first interval is as long as at a speed of the
// root of the count, rounded up.
static void first_interval_of_each_smooth_count(void)
{
    const uint16_t pixel_ticks = 60000u;
    uint16_t root = 1;

    for (int16_t count = 1; count <= 70; count++) {
        while ((uint16_t)(root * root) < (uint16_t)count) {
            root++;
        }
        for (uint16_t more = 0; more <= 1; more++) {
            setUp();
            limits.pixel_ticks = pixel_ticks;
            limits.reversal_min_ticks = (uint16_t)(pixel_ticks / root + more);
            begin_plain();
            taken(10, 1);
            ends();
            begin(LINE_MARK_START | LINE_START_SMOOTH | LINE_START_NEGATIVE, 0, 0);
            if (more == 0) {
                taken(count, 1);
            } else {
                refused(LINE_reversal_too_fast, 1, count, 1);
            }
        }
    }
}

static void reversal_needs_a_ramp_above_the_start_stop_speed(void)
{
    limits.start_stop_steps = 20;
    begin_plain();
    taken(20, 2);
    taken(-20, 1);
    taken(-40, 1);
    taken(-20, 1);
    refused(LINE_reversal_without_ramp, 6, 21, 1);
    setUp();
    limits.start_stop_steps = 20;
    begin_plain();
    taken(21, 1);
    refused(LINE_reversal_without_ramp, 2, -1, 1);
}

static void a_rest_or_no_limit_lets_any_reversal_pass(void)
{
    limits.start_stop_steps = 20;
    begin_plain();
    taken(300, 1);
    taken(0, 1);
    taken(-300, 1);
    ends();
    setUp();
    begin_plain();
    taken(300, 1);
    taken(-300, 1);
    ends();
}

static void seek_may_be_smooth_but_takes_up_no_backlash(void)
{
    begin(SEEK | LINE_START_SMOOTH, 0, 0);
    taken(4, 1);
    taken(8, 100);
    taken(LINE_MARK_DOWN, 0);
    taken(4, 1);
    ends();
    taken((int16_t)(SEEK | LINE_START_SMOOTH), 0);
    refused(LINE_backlash_plain, 1, 4, 8);
}

static void seek_needs_one_down_mark(void)
{
    begin(SEEK, 0, 0);
    taken(3, 100);
    taken(LINE_MARK_DOWN, 0);
    taken(1, 1);
    ends();
    begin(SEEK | LINE_START_OPEN, 0, 0);
    taken(-3, 100);
    refused(LINE_malformed, 101, LINE_MARK_END, 0);
    setUp();
    begin(SEEK, 0, 0);
    taken(LINE_MARK_DOWN, 0);
    refused(LINE_malformed, 1, LINE_MARK_DOWN, 0);
    setUp();
    begin_plain();
    refused(LINE_malformed, 1, LINE_MARK_DOWN, 0);
}

static void seek_does_not_wait(void)
{
    refused(LINE_malformed, 1, (int16_t)(SEEK | LINE_START_WAIT), 0);
    setUp();
    refused(LINE_malformed, 1, (int16_t)(LINE_MARK_START | LINE_START_OPEN), 0);
}

// A seek that trips leaves out segments and rests, so that other segments become neighbours.
static void seek_goes_one_way(void)
{
    begin(SEEK, 0, 0);
    taken(3, 1);
    taken(0, 100);
    refused(LINE_seek_reverses, 102, -3, 1);
    setUp();
    begin(SEEK, 0, 0);
    taken(-3, 1);
    taken(LINE_MARK_DOWN, 0);
    refused(LINE_seek_reverses, 2, 1, 1);
    setUp();
    begin_plain();
    taken(3, 1);
    ends();
    begin(SEEK, 0, 0); // whatever came before
    taken(-300, 1);
}

// A seek needs longer intervals, because the edge of its switch must be placed among the steps.
static void seek_keeps_the_longer_intervals(void)
{
    limits.min_interval_ticks = 200;
    begin_plain();
    taken(533333 / 200, 1);
    setUp();
    limits.min_interval_ticks = 200;
    limits.seek_min_interval_ticks = 400;
    begin(SEEK, 0, 0);
    taken(533333 / 400, 1);
    refused(LINE_too_fast, 2, 533333 / 400 + 1, 1);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(reversal_too_fast);
    RUN_TEST(slow_pixel_between_makes_the_reversal_possible);
    RUN_TEST(rests_add_up);
    RUN_TEST(reversal_into_a_chained_line);
    RUN_TEST(reversal_into_a_line_that_waits);
    RUN_TEST(reversal_into_a_chained_smooth_line);
    RUN_TEST(first_interval_of_each_smooth_count);
    RUN_TEST(reversal_needs_a_ramp_above_the_start_stop_speed);
    RUN_TEST(a_rest_or_no_limit_lets_any_reversal_pass);
    RUN_TEST(seek_may_be_smooth_but_takes_up_no_backlash);
    RUN_TEST(seek_needs_one_down_mark);
    RUN_TEST(seek_does_not_wait);
    RUN_TEST(seek_goes_one_way);
    RUN_TEST(seek_keeps_the_longer_intervals);
    return UNITY_END();
}
