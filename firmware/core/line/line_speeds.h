// SPDX-License-Identifier: MIT
// How fast a line that is being checked may be, and how fast it was. Main loop only; the host tools
// run the same code.
//
//     line_speeds_allow()    once a line: the highest speed that a line of its kind may have
//     line_speeds_note()     a segment that was looked at closely: the fastest speed so far
//     line_speeds_fit()      when it is armed: does all that was noted keep the shortest intervals
//                            of that many axes at once?
//
// A speed, steps/pixel, keeps a shortest interval if and only if speed * interval <= pixel, ticks:
// no segment needs a division. The fraction of a tick that a pixel may have is left out, which can
// only make the check stricter.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "line/line_check_state.h" // struct line_check

// True when this speed, steps/pixel, has shorter intervals than interval_ticks in pixels of
// pixel_ticks ticks. One product.
bool line_speeds_too_fast(uint16_t speed, uint16_t interval_ticks, uint32_t pixel_ticks);

// Set check->top_speed, the highest speed that keeps the shortest interval of a line of this kind.
// To be called when the kind is known, and again when the limits have changed. Divides, once for
// all segments.
void line_speeds_allow(struct line_check *check, const struct line_limits *limits);

#if SEVERAL_AXES
// Take the fastest speeds of the check as it was before the line began: they count as long as lines
// wait in the queue.
static inline void line_speeds_keep(struct line_check *check,
                                    const struct line_check *before)
{
    check->fastest_plain = before->fastest_plain;
    check->fastest_smooth = before->fastest_smooth;
}

// Note a speed that was accepted, steps/pixel. A seek's speed is slow enough for any company, and
// is not noted.
static inline void line_speeds_note(struct line_check *check, uint16_t speed)
{
    uint16_t *fastest = check->smooth ? &check->fastest_smooth : &check->fastest_plain;

    if (!(FEATURE_HOMING && check->one_way) && speed > *fastest) {
        *fastest = speed;
    }
}

// The fastest speed that was noted for lines of this kind, steps/pixel: a segment up to that speed
// needs no note. UINT16_MAX in a seek, which notes nothing.
static inline uint16_t line_speeds_fastest(const struct line_check *check)
{
    if (FEATURE_HOMING && check->one_way) {
        return UINT16_MAX;
    }
    return check->smooth ? check->fastest_smooth : check->fastest_plain;
}

// True when everything accepted since the reset keeps the shortest intervals of these limits too,
// which are longer where more axes move at once. Two products.
bool line_speeds_fit(const struct line_check *check, const struct line_limits *limits);
#else
// A single axis has no company: nothing is kept, noted or looked up.
static inline void line_speeds_keep(struct line_check *check,
                                    const struct line_check *before)
{
    (void)check;
    (void)before;
}

static inline void line_speeds_note(struct line_check *check, uint16_t speed)
{
    (void)check;
    (void)speed;
}

static inline uint16_t line_speeds_fastest(const struct line_check *check)
{
    (void)check;
    return UINT16_MAX;
}
#endif
