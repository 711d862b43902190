// SPDX-License-Identifier: MIT
// Is this a line the board can run? Fed run by run as they arrive, so that a line longer than the
// memory is checked too; nothing may be armed before its end mark has been accepted, or, when the
// line is streamed, runs past a refused one never reach the decoder. Same code on the host.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "base/names.h"     // enum line_error
#include "motion/segment.h" // struct segment

// What the board and its settings allow; ticks are timer ticks.
struct line_limits {
    uint32_t pixel_ticks;               // whole ticks of a pixel period
    uint16_t min_interval_ticks;        // shortest interval between two steps, plain line
    uint16_t smooth_min_interval_ticks; // the same in a smooth line
    uint16_t seek_min_interval_ticks;   // the same in seeks
    uint16_t reversal_min_ticks;        // the same between steps of opposite direction
    uint16_t max_acceleration;          // steps/pixel^2 of a smooth line, 0: any
    uint16_t start_stop_steps;          // of both pixels at a direct reversal, 0: any
};

enum line_check_phase {
    LINE_CHECK_OUTSIDE, // a start mark must come next
    LINE_CHECK_PARAMETER,
    LINE_CHECK_SEGMENTS,
};

struct line_check {
    uint8_t phase;
    bool smooth : 1;
    bool reached : 1;  // the line speed given with the backlash was reached
    bool negative : 1; // direction of a smooth line
    bool seek : 1;     // its down mark is still to come
    bool one_way : 1;  // a seek: any of its runs may come next when it trips
    int8_t
        direction; // of the last step, 0: none yet or long ago; kept across chained lines
    uint8_t warning; // first warning of the line (enum line_error, 32..)
    uint16_t backlash_steps;
    uint16_t line_speed;
    uint16_t rest_ticks; // whole zero pixels since that step, 0xFFFF: that or more
    uint16_t speed;      // at the end of the last pixel
    int16_t last_count;  // of the last pixel
    uint32_t pixel; // pixels accepted so far: the next entry begins with the one after
};

void line_check_reset(struct line_check *check);

// Accept the next entry, or say why not: something about the pixel behind check->pixel. After a
// refusal the check must be reset.
enum line_error line_check_entry(struct line_check *check,
                                 const struct line_limits *limits,
                                 struct segment entry);
