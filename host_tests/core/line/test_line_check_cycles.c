// SPDX-License-Identifier: MIT
// Budgets of the line check on a board: cycles for each entry of a line by its kind. Natively no
// cycles are counted, and every budget holds.
#include <stdint.h>

#include "cycles.h"
#include "line/line_check.h"
#include "unity.h"

#define PIXELS 16u

static struct line_check check;
static struct line_limits limits;

void setUp(void)
{
    cycles_start();
    limits = (struct line_limits){
        .pixel_ticks = 32000,
        .min_interval_ticks = 266,
        .smooth_min_interval_ticks = 400,
        .seek_min_interval_ticks = 400,
        .reversal_min_ticks = 4240,
    };
    line_check_reset(&check);
#if SEVERAL_AXES
    // A line that waits in the queue is faster: the first pixel faster than any before costs as
    // much as a rest.
    check.fastest_plain = UINT16_MAX;
    check.fastest_smooth = UINT16_MAX;
#endif
}

void tearDown(void)
{
}

static void begin(uint16_t word, int16_t backlash_steps, uint16_t line_speed)
{
    TEST_ASSERT_EQUAL(
        LINE_none,
        line_check_entry(
            &check, &limits, (struct segment){(int16_t)(LINE_MARK_START | word), 0}));
    TEST_ASSERT_EQUAL(
        LINE_none,
        line_check_entry(&check, &limits, (struct segment){backlash_steps, line_speed}));
}

// The cycles of one entry, its call included.
static uint16_t entry_cycles(int16_t count, uint16_t repeat)
{
    uint16_t start = cycles_now();
    enum line_error error =
        line_check_entry(&check, &limits, (struct segment){count, repeat});
    uint16_t cycles = (uint16_t)(cycles_now() - start);

    TEST_ASSERT_EQUAL(LINE_none, error);
    return cycles;
}

// The most cycles of some pixels whose counts go on from `count` by `change`, the first left out.
static uint16_t worst_from(int16_t count, int16_t change)
{
    uint16_t worst = 0;

    (void)entry_cycles(count, 1);
    count = (int16_t)(count + change);
    for (uint8_t i = 0; i < PIXELS; i++) {
        uint16_t cycles = entry_cycles(count, 1);
        worst = cycles > worst ? cycles : worst;
        count = (int16_t)(count + change);
    }
    return worst;
}

static void plain_pixels(void)
{
    begin(0, 0, 0);
    TEST_ASSERT_LESS_OR_EQUAL_UINT16(150, worst_from(20, -1));
}

static void plain_pixels_backwards(void)
{
    begin(0, 0, 0);
    TEST_ASSERT_LESS_OR_EQUAL_UINT16(150, worst_from(-2, -2));
}

static void plain_runs(void)
{
    begin(0, 0, 0);
    (void)entry_cycles(20, 300);
    TEST_ASSERT_LESS_OR_EQUAL_UINT16(150, entry_cycles(11, 300));
}

static void smooth_pixels(void)
{
    limits.max_acceleration = 30;
    begin(LINE_START_SMOOTH, 0, 0);
    (void)entry_cycles(5, 1);
    TEST_ASSERT_LESS_OR_EQUAL_UINT16(160, worst_from(11, 2));
}

static void smooth_constant_speed(void)
{
    begin(LINE_START_SMOOTH, 0, 0);
    (void)entry_cycles(5, 1);
    (void)entry_cycles(10, 1);
    TEST_ASSERT_LESS_OR_EQUAL_UINT16(150, entry_cycles(10, 1));
    TEST_ASSERT_LESS_OR_EQUAL_UINT16(150, entry_cycles(10, 100));
}

static void smooth_behind_the_backlash(void)
{
    begin(LINE_START_SMOOTH, 4, 10);
    (void)entry_cycles(0, 1);
    (void)entry_cycles(5, 1);
    (void)entry_cycles(10, 1);
    TEST_ASSERT_LESS_OR_EQUAL_UINT16(150, entry_cycles(10, 1));
}

// These are rare in a line.
static void rests_and_reversals(void)
{
    begin(0, 0, 0);
    (void)entry_cycles(2, 1);
    TEST_ASSERT_LESS_OR_EQUAL_UINT16(360, entry_cycles(0, 1));
    TEST_ASSERT_LESS_OR_EQUAL_UINT16(360, entry_cycles(-2, 1));
    TEST_ASSERT_LESS_OR_EQUAL_UINT16(450, entry_cycles(2, 1));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(plain_pixels);
    RUN_TEST(plain_pixels_backwards);
    RUN_TEST(plain_runs);
    RUN_TEST(smooth_pixels);
    RUN_TEST(smooth_constant_speed);
    RUN_TEST(smooth_behind_the_backlash);
    RUN_TEST(rests_and_reversals);
    return UNITY_END();
}
