// SPDX-License-Identifier: MIT
#include "line/line_check_head.h"

#include "base/apart.h"        // APART
#include "line/line_divider.h" // line_divider_take
#include "line/line_speeds.h"  // line_speeds_*

void line_check_reset(struct line_check *check)
{
    *check = (struct line_check){.phase = LINE_CHECK_OUTSIDE};
}

// Flags of a start mark that exclude each other, by the bytes of its word; 0: none. A seek must not
// wait for the pixel clock, and only a seek may have the bit for an opening switch.
static inline uint8_t misfits(uint8_t more, uint8_t flags)
{
    if ((flags & LINE_START_SEEK) != 0) {
        return flags & LINE_START_WAIT;
    }
    return more & LINE_START_OPEN >> 8;
}

// What is wrong with a start mark, whose bytes are `more` and `flags`.
static inline enum line_error judge_start_mark(struct segment entry,
                                               uint8_t more,
                                               uint8_t flags)
{
    if (entry.repeat != 0 ||
        ((uint16_t)entry.count & (uint16_t)~LINE_START_FLAGS) != LINE_MARK_START ||
        misfits(more, flags) != 0) {
        return LINE_malformed;
    }
    if ((!FEATURE_HOMING && (flags & LINE_START_SEEK) != 0) ||
        (!FEATURE_LINE_DIVIDER && (more & LINE_START_DIVIDER >> 8) != 0)) {
        return LINE_not_built;
    }
    return LINE_none;
}

// Begin to check a line, by the bytes of its start mark.
static inline void begin_line(struct line_check *check, uint8_t more, uint8_t flags)
{
    // A line that waits for the clock starts from rest, and so does a seek, which is always armed
    // by itself. Any other line may follow the one before without a pause and inherits its
    // direction.
    bool chained = (flags & (LINE_START_WAIT | LINE_START_SEEK)) == 0;
    uint8_t behind = check->flags & LINE_CHECK_BEHIND;
    struct line_check before = *check;

    line_check_reset(check);
    if (chained) {
        check->direction = before.direction;
        check->rest_ticks = before.rest_ticks;
    }
    line_speeds_keep(check, &before);
    check->flags = flags & LINE_START_KEPT;
    if ((flags & LINE_START_SEEK) != 0) {
        check->one_way = true;
    }
    if (FEATURE_LINE_DIVIDER && (more & LINE_START_DIVIDER >> 8) != 0) {
        check->divided = true;
    }
    if (FEATURE_LINE_DIVIDER && behind != 0) {
        check->behind = true;
    }
    check->phase = LINE_CHECK_PARAMETER;
}

static enum line_error check_start_mark(struct line_check *check, struct segment entry)
{
    uint8_t flags = (uint8_t)entry.count;
    uint8_t more = (uint8_t)((uint16_t)entry.count >> 8);

    BY_BYTE(flags);
    BY_BYTE(more);
    enum line_error error = judge_start_mark(entry, more, flags);
    if (error == LINE_none) {
        begin_line(check, more, flags);
    }
    return error;
}

static enum line_error check_backlash(const struct line_check *check)
{
    if (check->backlash_steps == 0) {
        return LINE_none;
    }
    if (!FEATURE_BACKLASH) {
        return LINE_not_built;
    }
    if (!check->smooth || line_check_seeks(check)) {
        return LINE_backlash_plain;
    }
    if (check->line_speed > 2 * LINE_COUNT_MAX) {
        return LINE_out_of_range;
    }
    if ((check->line_speed & 1u) != 0) {
        return LINE_odd_speed;
    }
    return check->backlash_steps > check->line_speed ? LINE_backlash_over_speed
                                                     : LINE_none;
}

static enum line_error check_parameter(struct line_check *check,
                                       const struct line_limits *limits,
                                       struct segment entry)
{
    check->backlash_steps = (uint16_t)entry.count;
    check->line_speed = entry.repeat;
    check->phase =
        FEATURE_LINE_DIVIDER && check->divided ? LINE_CHECK_DIVIDER : LINE_CHECK_SEGMENTS;
    line_speeds_allow(check, limits);
    return check_backlash(check);
}

// Let the divider change what a pixel is, before a segment is checked.
static enum line_error check_divider(struct line_check *check,
                                     const struct line_limits *limits,
                                     struct segment entry)
{
    if (entry.repeat != 0) {
        return LINE_malformed;
    }
    if (!line_divider_take((uint16_t)entry.count, check->behind)) {
        return LINE_divider;
    }
    check->phase = LINE_CHECK_SEGMENTS;
    line_speeds_allow(check, limits);
    return LINE_none;
}

enum line_error APART line_check_head(struct line_check *check,
                                      const struct line_limits *limits,
                                      struct segment entry)
{
    if (check->phase == LINE_CHECK_OUTSIDE) {
        return check_start_mark(check, entry);
    }
    if (!FEATURE_LINE_DIVIDER || check->phase == LINE_CHECK_PARAMETER) {
        return check_parameter(check, limits, entry);
    }
    return check_divider(check, limits, entry);
}
