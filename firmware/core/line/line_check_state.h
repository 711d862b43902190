// SPDX-License-Identifier: MIT
// What the check of lines knows of the line that it is in (line_check.h), and who writes it:
//
//     line_check_head.c    flags, backlash, line speed: from what stands in front of the segments
//     line_speeds.h        top speed and fastest speeds
//     line_check.c         all else, segment by segment
//
// A copy of it is a second check of the same line: a block is checked on a copy, and an error in
// the block leaves the axis's own as it was.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "build_features.h" // FEATURE_*

// Largest count: the curve decoder multiplies speeds, which are up to 2 * count, by piece lengths
// in 40 bits.
#define LINE_COUNT_MAX 16383

// What the board and its settings allow. Times are in timer ticks.
struct line_limits {
    // Whole ticks of a pixel period; intervals are judged with the fraction left out.
    uint32_t pixel_ticks;
    // Shortest interval between two steps of a plain line.
    uint16_t min_interval_ticks;
    // Shortest interval of a smooth line.
    uint16_t smooth_min_interval_ticks;
    // Shortest interval of a seek.
    uint16_t seek_min_interval_ticks;
    // Shortest interval between two steps of opposite direction.
    uint16_t reversal_min_ticks;
    // Largest acceleration of a smooth line, steps/pixel^2; 0: any.
    uint16_t max_acceleration;
    // Largest count of both pixels at a direct reversal; 0: any.
    uint16_t start_stop_steps;
#if FEATURE_LINE_DIVIDER
    // Clock edges of a pixel, which a line's divider must be; 0: any, the limits are those of the
    // line.
    uint16_t divider;
#endif
};

enum line_check_phase {
    // A start mark must come next.
    LINE_CHECK_OUTSIDE,
    // The parameter of the start mark must come next.
    LINE_CHECK_PARAMETER,
    // The divider of the start mark must come next.
    LINE_CHECK_DIVIDER,
    // A segment or a mark must come next.
    LINE_CHECK_SEGMENTS,
};

// Of the flags of struct line_check `begun` and `behind`.
#define LINE_CHECK_BEHIND 0x24u

struct line_check {
    // enum line_check_phase.
    uint8_t phase;
    union {
        // The flags below. Smooth, negative and seek are at the bits of the start mark's flags.
        uint8_t flags;
        struct {
            // The line reached the line speed of the backlash parameter.
            bool reached : 1;
            // The line is a seek: when it trips, any segment behind the down mark may come next.
            bool one_way : 1;
            // A segment of the line was accepted.
            bool begun : 1;
            // A divider follows the parameter.
            bool divided : 1;
            // The line has constant acceleration inside a pixel.
            bool smooth : 1;
            // Segments of another line were accepted before this one, since the reset.
            bool behind : 1;
            // Direction of a smooth line.
            bool negative : 1;
            // The line is a seek whose down mark is still to come.
            bool seek : 1;
        };
    };
    int8_t
        direction; // of the last step, 0: none yet or long ago; kept across chained lines
    // First warning of the line (enum line_error, from 32 on).
    uint8_t warning;
    // The parameter of the start mark: steps of play to take up, and the speed V (steps/pixel) at
    // which the line takes them up.
    uint16_t backlash_steps;
    uint16_t line_speed;
    // Highest speed of the line, steps/pixel: of a plain line the largest count.
    uint16_t top_speed;
    // A segment up to this speed that goes on as the line does needs no closer look; 0: none.
    uint16_t easy_speed;
    // Length of the zero pixels since the last step, ticks; 0xFFFF: that or more.
    uint16_t rest_ticks;
    // Speed at the end of the last pixel, steps/pixel.
    uint16_t speed;
    // Count of the last pixel.
    int16_t last_count;
#if SEVERAL_AXES
    // Highest speed of the plain and of the smooth lines, steps/pixel, chained or not: for
    // line_speeds_fit(). Seeks are slow enough for any company.
    uint16_t fastest_plain;
    uint16_t fastest_smooth;
#endif
    // Pixels accepted so far: the next entry begins with the pixel behind it.
    uint32_t pixel;
};

// True in a seek whose down mark is still to come.
static inline bool line_check_seeks(const struct line_check *check)
{
    return FEATURE_HOMING && check->seek;
}

static inline bool line_check_has_backlash(const struct line_check *check)
{
    return FEATURE_BACKLASH && check->backlash_steps != 0;
}
