// SPDX-License-Identifier: MIT
// For suites of line/line_check.h: a check with limits, entries taken or refused.
#pragma once

#include <stdint.h>

#include "line/line_check.h"
#include "line/line_divider.h"
#include "unity.h"

#define SMOOTH ((uint16_t)(LINE_MARK_START | LINE_START_SMOOTH | LINE_START_WAIT))
#define PLAIN  ((uint16_t)(LINE_MARK_START | LINE_START_WAIT))
#define SEEK   ((uint16_t)(LINE_MARK_START | LINE_START_SEEK))

static struct line_check check;
static struct line_limits limits;
static uint32_t warning_pixel; // of the run that brought the warning
// The divider that a line asked for, and whether it came behind another line; from 1000 on refused.
static uint16_t divider;
static bool divider_behind;

bool line_divider_take(uint16_t edges, bool behind)
{
    divider = edges;
    divider_behind = behind;
    limits.pixel_ticks *= edges;
    return edges < 1000;
}

void setUp(void)
{
    line_check_reset(&check);
    limits = (struct line_limits){
        .pixel_ticks = 533333uL,
        .min_interval_ticks = 400,
        .smooth_min_interval_ticks = 400,
        .reversal_min_ticks = 1664,
    };
}

void tearDown(void)
{
}

static inline enum line_error entry(int16_t count, uint16_t repeat)
{
    uint32_t pixel = check.pixel + 1u;
    uint8_t warning = check.warning;
    enum line_error error =
        line_check_entry(&check, &limits, (struct segment){count, repeat});

    if (check.warning != warning) {
        warning_pixel = pixel;
    }
    return error;
}

static inline void taken(int16_t count, uint16_t repeat)
{
    TEST_ASSERT_EQUAL(LINE_none, entry(count, repeat));
}

static inline void refused(enum line_error error,
                           uint32_t pixel,
                           int16_t count,
                           uint16_t repeat)
{
    TEST_ASSERT_EQUAL(error, entry(count, repeat));
    TEST_ASSERT_EQUAL_UINT32(pixel, check.pixel + 1u);
}

static inline void begin(uint16_t mark, uint16_t backlash, uint16_t speed)
{
    taken((int16_t)mark, 0);
    taken((int16_t)backlash, speed);
}

static inline void begin_smooth(void)
{
    begin(SMOOTH, 0, 0);
}

static inline void begin_plain(void)
{
    begin(PLAIN, 0, 0);
}

static inline void ends(void)
{
    taken(LINE_MARK_END, 0);
    TEST_ASSERT_EQUAL(LINE_CHECK_OUTSIDE, check.phase);
}
