// SPDX-License-Identifier: MIT
// What the check of lines knows of the line that it is in (line_check.h), and who writes it:
//
//     line_check_head.c    flags, backlash, line speed: from what stands in front of the segments
//     line_speeds.h        top speed and fastest speeds
//     line_check.c         all else, segment by segment
//
// A copy of the state is a second check of the same line: a block is checked on a copy, and an
// error in the block leaves the axis's own state as it was. Main loop, and the host tools.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "build_features.h" // FEATURE_*

// Largest count: the curve decoder multiplies speeds, which are up to 2 * count, by piece lengths
// in 40 bits.
#define LINE_COUNT_MAX 16383

// What the board and its settings allow. Times are in timer ticks. app/axes/limits.c makes the
// limits of the board; a check only reads them.
struct line_limits {
    // Whole ticks of a pixel period; intervals are judged with the fraction left out.
    uint32_t pixel_ticks;
    // Shortest interval between two steps of a plain line. Not 0, like the next two.
    uint16_t min_interval_ticks;
    // Shortest interval of a smooth line.
    uint16_t smooth_min_interval_ticks;
    // Shortest interval of a seek.
    uint16_t seek_min_interval_ticks;
    // Shortest interval between two steps of opposite direction.
    uint16_t reversal_min_ticks;
    // Largest change of speed in a pixel of a smooth line, steps/pixel^2; 0: any.
    uint16_t max_acceleration;
    // Largest count, steps, of both pixels at a reversal of a plain line without a pixel of rest in
    // between; 0: any.
    uint16_t start_stop_steps;
#if FEATURE_LINE_DIVIDER
    // Clock edges of a pixel, 1..1000: a line that tells a divider must tell this one. 0: it may
    // tell any, and the other limits were made for that line.
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

// The bits of struct line_check's `flags` that are `begun` and `behind`: with one of them set, a
// line that starts now has segments of another line before it.
#define LINE_CHECK_BEHIND 0x24u

// The check of one axis's lines. The functions of the line_check headers write it; axis.c clears
// `behind` when nothing but a line's head is left in the queue.
struct line_check {
    // enum line_check_phase.
    uint8_t phase;
    union {
        // The flags below. Smooth, negative and seek are at the bits of the start mark's flags.
        uint8_t flags;
        struct {
            // The line reached the line speed of the backlash parameter.
            bool reached : 1;
            // The line is a seek: when it trips, any segment after the down mark may come next.
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
    // Direction of the last step, 1 or -1; 0: any direction may come. A line that may follow
    // another one without a pause takes the direction over.
    int8_t direction;
    // First warning about the line (enum line_error, from 32 on); 0: none.
    uint8_t warning;
    // The parameter of the start mark: steps of play to take up, and the speed V (steps/pixel) at
    // which the line takes them up.
    uint16_t backlash_steps;
    uint16_t line_speed;
    // Highest speed that the limits allow this line, steps/pixel: of a plain line the largest
    // count.
    uint16_t top_speed;
    // A segment up to this speed, steps/pixel, that goes on as the line does needs no closer look;
    // 0: none.
    uint16_t easy_speed;
    // Length of the zero pixels since the last step, ticks; 0xFFFF: that or more.
    uint16_t rest_ticks;
    // Speed at the end of the last pixel, steps/pixel; of a smooth line only.
    uint16_t speed;
    // Count of the last pixel, steps.
    int16_t last_count;
#if SEVERAL_AXES
    // Highest speed that was accepted in plain lines since the reset, steps/pixel: for
    // line_speeds_fit(). Seeks do not count: they are slow enough for any company.
    uint16_t fastest_plain;
    // Highest speed that was accepted in smooth lines since the reset, steps/pixel.
    uint16_t fastest_smooth;
#endif
    // Pixels of the line accepted so far: the next entry begins with the pixel after them.
    uint32_t pixel;
};

// True in a seek whose down mark is still to come.
static inline bool line_check_seeks(const struct line_check *check)
{
    return FEATURE_HOMING && check->seek;
}

// True in a line that takes up backlash; false in an image without that feature.
static inline bool line_check_has_backlash(const struct line_check *check)
{
    return FEATURE_BACKLASH && check->backlash_steps != 0;
}
