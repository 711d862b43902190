// SPDX-License-Identifier: MIT
// Checks whether the board can run a line. The check gets the segments one by one as they arrive,
// so that a line longer than the memory is checked too. A line may be armed only when its end mark
// was accepted; of a line that is streamed, no segment behind a refused one reaches the decoder.
// The host tools run the same code.
//
//     OUTSIDE -- start mark --> PARAMETER -- parameter --> SEGMENTS -- end mark --> OUTSIDE
//                                    |                     ^ |  ^ segment, down mark
//                          parameter |                     | +--+
//                                    +-------> DIVIDER ----+ divider
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "base/names.h"     // enum line_error
#include "build_features.h" // SEVERAL_AXES
#include "motion/segment.h" // struct segment

// What the board and its settings allow. Times are in timer ticks.
struct line_limits {
    // Whole ticks of a pixel period; intervals are judged with the fraction left out.
    uint32_t pixel_ticks;
    // Shortest interval between two steps of a plain line,
    uint16_t min_interval_ticks;
    // of a smooth line,
    uint16_t smooth_min_interval_ticks;
    // of a seek,
    uint16_t seek_min_interval_ticks;
    // and between two steps of opposite direction.
    uint16_t reversal_min_ticks;
    // Largest acceleration of a smooth line, steps/pixel^2; 0: any.
    uint16_t max_acceleration;
    // Largest count of both pixels at a direct reversal; 0: any.
    uint16_t start_stop_steps;
};

enum line_check_phase {
    // A start mark must come next.
    LINE_CHECK_OUTSIDE,
    // The parameter of the start mark must come next.
    LINE_CHECK_PARAMETER,
    // The divider of the start mark must come next. It may change the limits (line_divider.h).
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
    // line_check_fits(). Seeks are slow enough for any company.
    uint16_t fastest_plain;
    uint16_t fastest_smooth;
#endif
    // Pixels accepted so far: the next entry begins with the pixel behind it.
    uint32_t pixel;
};

// Expect the start of a line that follows no other: any direction may come first.
void line_check_reset(struct line_check *check);

#if SEVERAL_AXES
// True when everything accepted since the reset keeps these limits' shortest intervals too.
bool line_check_fits(const struct line_check *check, const struct line_limits *limits);
#endif

// The limits may be others than those of the entries before. Divides.
void line_check_limits(struct line_check *check, const struct line_limits *limits);

// Accept the next entry, or return why not; the reason concerns the pixel behind check->pixel.
// After a refusal the check must be reset.
enum line_error line_check_entry(struct line_check *check,
                                 const struct line_limits *limits,
                                 struct segment entry);
