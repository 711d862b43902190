// SPDX-License-Identifier: MIT
#include "motion/line_check.h"

#include "base/apart.h"          // APART
#include "base/divide.h"         // divide_u32_u16
#include "base/multiply.h"       // multiply_u32_u16
#include "build_features.h"      // FEATURE_*
#include "motion/line_divider.h" // line_divider_take

// Largest count: the curve decoder multiplies speeds, which are up to 2 * count, by piece lengths
// in 40 bits.
#define COUNT_MAX 16383

void line_check_reset(struct line_check *check)
{
    *check = (struct line_check){.phase = LINE_CHECK_OUTSIDE};
}

// True in a seek whose down mark is still to come.
static inline bool is_seek(const struct line_check *check)
{
    return FEATURE_HOMING && check->seek;
}

static inline bool has_backlash(const struct line_check *check)
{
    return FEATURE_BACKLASH && check->backlash_steps != 0;
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

// The speeds of lines that wait in the queue count as long as the queue is not empty.
#if SEVERAL_AXES
static void keep_fastest(struct line_check *check, const struct line_check *before)
{
    check->fastest_plain = before->fastest_plain;
    check->fastest_smooth = before->fastest_smooth;
}

static void note_fastest(struct line_check *check, uint16_t speed)
{
    uint16_t *fastest = check->smooth ? &check->fastest_smooth : &check->fastest_plain;

    if (!(FEATURE_HOMING && check->one_way) && speed > *fastest) {
        *fastest = speed;
    }
}
// What is faster than anything before must be noted.
static uint16_t fastest_noted(const struct line_check *check)
{
    if (FEATURE_HOMING && check->one_way) {
        return UINT16_MAX;
    }
    return check->smooth ? check->fastest_smooth : check->fastest_plain;
}
#else
static uint16_t fastest_noted(const struct line_check *check)
{
    (void)check;
    return UINT16_MAX;
}

static void keep_fastest(struct line_check *check, const struct line_check *before)
{
    (void)check;
    (void)before;
}

static void note_fastest(struct line_check *check, uint16_t speed)
{
    (void)check;
    (void)speed;
}
#endif

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
    keep_fastest(check, &before);
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

static bool APART too_fast(uint16_t speed, uint16_t interval_ticks, uint32_t pixel_ticks)
{
    return (uint32_t)speed * interval_ticks > pixel_ticks;
}

// A seek needs longer intervals than other lines: the capture interrupt places the switch's edge
// among the steps.
static uint16_t shortest_interval(const struct line_check *check,
                                  const struct line_limits *limits)
{
    if (FEATURE_HOMING && check->one_way) {
        return limits->seek_min_interval_ticks;
    }
    return check->smooth ? limits->smooth_min_interval_ticks : limits->min_interval_ticks;
}

// Note the highest speed that keeps the shortest interval: one division for the whole line, since
// speed * interval > pixel if and only if speed > floor(pixel / interval).
static APART void note_top_speed(struct line_check *check,
                                 const struct line_limits *limits)
{
    uint16_t interval = shortest_interval(check, limits);

    check->top_speed = limits->pixel_ticks >> 16 < interval
                           ? divide_u32_u16(limits->pixel_ticks, interval)
                           : UINT16_MAX;
}

static enum line_error check_backlash(const struct line_check *check)
{
    if (check->backlash_steps == 0) {
        return LINE_none;
    }
    if (!FEATURE_BACKLASH) {
        return LINE_not_built;
    }
    if (!check->smooth || is_seek(check)) {
        return LINE_backlash_plain;
    }
    if (check->line_speed > 2 * COUNT_MAX) {
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
    note_top_speed(check, limits);
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
    note_top_speed(check, limits);
    return LINE_none;
}

#if SEVERAL_AXES
bool line_check_fits(const struct line_check *check, const struct line_limits *limits)
{
    return !too_fast(
               check->fastest_plain, limits->min_interval_ticks, limits->pixel_ticks) &&
           !too_fast(check->fastest_smooth,
                     limits->smooth_min_interval_ticks,
                     limits->pixel_ticks);
}
#endif

static uint16_t magnitude_of(int16_t value)
{
    return (uint16_t)(value < 0 ? -value : value);
}

static void note_warning(struct line_check *check, enum line_error warning)
{
    if (check->warning == LINE_none) {
        check->warning = (uint8_t)warning;
    }
}

static uint16_t steps_of(struct segment entry)
{
    return magnitude_of(entry.count);
}

static enum line_error check_plain_segment(struct line_check *check, struct segment entry)
{
    if (steps_of(entry) > check->top_speed) {
        return LINE_too_fast;
    }
    note_fastest(check, steps_of(entry));
    return LINE_none;
}

static int8_t direction_of(const struct line_check *check, struct segment entry)
{
    if (entry.count == 0) {
        return 0;
    }
    bool negative = check->smooth ? check->negative : entry.count < 0;

    return negative ? -1 : 1;
}

// The speed whose interval is as long as the first interval after a rest: the count itself in a
// plain line, and its root, rounded up, in a smooth line, where the pixel accelerates from rest.
static uint16_t first_speed(const struct line_check *check, struct segment entry)
{
    uint16_t steps = steps_of(entry);
    uint8_t root = 1; // of COUNT_MAX: 128

    if (!check->smooth) {
        return steps;
    }
    while ((uint16_t)((uint16_t)root * root) < steps) {
        root++;
    }
    return root;
}

// True for a reversal from one pixel to the next that is faster than the motor can start and stop.
static bool lacks_ramp(const struct line_check *check,
                       const struct line_limits *limits,
                       struct segment entry)
{
    uint16_t most = limits->start_stop_steps;
    int16_t last = check->last_count;

    return most != 0 && check->rest_ticks == 0 && !check->smooth &&
           (steps_of(entry) > most || magnitude_of(last) > most);
}

// Refuse a reversal that leaves the driver too little time. The direction changes in the middle of
// the time between two steps, so that this time must be long enough.
static enum line_error APART check_reversal(const struct line_check *check,
                                            const struct line_limits *limits,
                                            struct segment entry)
{
    uint16_t wanted = limits->reversal_min_ticks;

    if (FEATURE_HOMING && check->one_way) {
        return LINE_seek_reverses;
    }
    if (lacks_ramp(check, limits, entry)) {
        return LINE_reversal_without_ramp;
    }
    if (check->rest_ticks >= wanted) {
        return LINE_none;
    }
    return too_fast(first_speed(check, entry),
                    (uint16_t)(wanted - check->rest_ticks),
                    limits->pixel_ticks)
               ? LINE_reversal_too_fast
               : LINE_none;
}

// Add zero pixels to the time at rest since the last pixel with steps.
static void APART note_rest(struct line_check *check,
                            const struct line_limits *limits,
                            struct segment entry)
{
    uint16_t pixel =
        limits->pixel_ticks > UINT16_MAX ? UINT16_MAX : (uint16_t)limits->pixel_ticks;
    uint32_t rest = (uint32_t)entry.repeat * pixel + check->rest_ticks;

    check->rest_ticks = rest > UINT16_MAX ? UINT16_MAX : (uint16_t)rest;
}

static uint16_t lesser(uint16_t one, uint16_t other)
{
    return one < other ? one : other;
}

// Note up to which speed the next segments need no closer look, now that a segment with steps was
// accepted.
static void note_easy_speed(struct line_check *check)
{
    uint16_t easy = check->top_speed;

    if (has_backlash(check)) {
        easy =
            check->reached ? check->line_speed : 0; // a speed that was reached is allowed
    }
    easy = lesser(easy, fastest_noted(check));
    check->easy_speed = lesser(easy, COUNT_MAX);
}

// Check the direction of a segment against that of the last pixel with steps, and keep it.
static enum line_error check_direction(struct line_check *check,
                                       const struct line_limits *limits,
                                       struct segment entry)
{
    int8_t direction = direction_of(check, entry);

    if (direction == 0) {
        note_rest(check, limits, entry);
        return LINE_none;
    }
    if (direction != check->direction && check->direction != 0) {
        enum line_error error = check_reversal(check, limits, entry);
        if (error != LINE_none) {
            return error;
        }
    }
    check->direction = direction;
    check->rest_ticks = 0;
    note_easy_speed(check);
    return LINE_none;
}

// Refuse equal counts that begin at another speed than their own, or warn of them: from pixel to
// pixel the error e = v - n only changes its sign, for ever.
static enum line_error check_equal_counts(struct line_check *check, struct segment entry)
{
    uint16_t amplitude = magnitude_of((int16_t)((int16_t)check->speed - entry.count));
    uint16_t steps = (uint16_t)entry.count;
    bool equal = entry.repeat > 1u || (entry.count == check->last_count && check->begun);

    if (amplitude == 0 || !equal) {
        return LINE_none;
    }
    if (amplitude > 2u && multiply_u32_u16(100, amplitude) > steps) {
        return LINE_oscillates;
    }
    note_warning(check, LINE_ripple);
    return LINE_none;
}

static bool too_steep(const struct line_limits *limits, int16_t acceleration)
{
    return limits->max_acceleration != 0 &&
           magnitude_of(acceleration) > limits->max_acceleration;
}

// Check speeds and accelerations of a smooth segment; `end_speed` is that of its first pixel.
static enum line_error APART check_smooth_speed(struct line_check *check,
                                                const struct line_limits *limits,
                                                struct segment entry,
                                                uint16_t end_speed)
{
    uint16_t top = end_speed > check->speed ? end_speed : check->speed;

    if (too_steep(limits, (int16_t)(end_speed - check->speed))) {
        return LINE_acceleration;
    }
    if (top > check->top_speed) {
        return LINE_too_fast;
    }
    note_fastest(check, top);
    if (has_backlash(check)) {
        if (!check->begun && entry.count != 0) {
            return LINE_backlash_no_room;
        }
        if (top > check->line_speed) {
            return LINE_speed_not_reached;
        }
        check->reached = check->reached || top == check->line_speed;
    }
    return LINE_none;
}

// Refuse counts that the arithmetic of a smooth pixel does not allow.
static enum line_error check_smooth_shape(const struct line_check *check,
                                          struct segment entry,
                                          int16_t end_speed)
{
    if (entry.count < 0) {
        return LINE_negative_count;
    }
    if (entry.count == 0 && check->speed != 0) {
        return LINE_zero_while_moving;
    }
    return end_speed < 0 ? LINE_reverses_inside_pixel : LINE_none;
}

static enum line_error check_smooth_segment(struct line_check *check,
                                            const struct line_limits *limits,
                                            struct segment entry)
{
    // Twice the count and the speed are both at most 2 * COUNT_MAX, so that 16 bits hold the
    // result.
    int16_t end_speed = (int16_t)(2 * entry.count - (int16_t)check->speed);
    enum line_error error = check_smooth_shape(check, entry, end_speed);

    if (error == LINE_none) {
        error = check_equal_counts(check, entry);
    }
    if (error == LINE_none) {
        error = check_smooth_speed(check, limits, entry, (uint16_t)end_speed);
    }
    if (error == LINE_none && (entry.repeat & 1u) != 0) {
        check->speed = (uint16_t)end_speed;
    }
    if (!check->begun && entry.count == 0 && !has_backlash(check)) {
        note_warning(check, LINE_idle_pixel);
    }
    return error;
}

// Check the end mark of a line, or the down mark of a seek.
static enum line_error check_mark(struct line_check *check, struct segment entry)
{
    if (is_seek(check) && (uint16_t)entry.count == LINE_MARK_DOWN) {
        check->seek = false;
        return LINE_none;
    }
    if (is_seek(check) || (uint16_t)entry.count != LINE_MARK_END) {
        return LINE_malformed;
    }
    if (check->smooth && check->speed != 0) {
        return LINE_ends_moving;
    }
    if (has_backlash(check) && !check->reached) {
        return LINE_speed_not_reached;
    }
    check->phase = LINE_CHECK_OUTSIDE;
    check->easy_speed = 0;
    return LINE_none;
}

static enum line_error check_closely(struct line_check *check,
                                     const struct line_limits *limits,
                                     struct segment entry)
{
    enum line_error error = LINE_none;

    if (entry.count > COUNT_MAX || entry.count < -COUNT_MAX) {
        return LINE_out_of_range;
    }
    if (check->smooth) {
        error = check_smooth_segment(check, limits, entry);
    } else {
        error = check_plain_segment(check, entry);
    }
    if (error == LINE_none) {
        error = check_direction(check, limits, entry);
    }
    return error;
}

// True for a segment of a smooth line that needs no closer look: speeds below the easy one, and
// equal counts entered at their own speed. A negative end speed is far above the easy one.
static inline bool is_easy_curve(const struct line_check *check,
                                 const struct line_limits *limits,
                                 struct segment entry)
{
    uint16_t steps = (uint16_t)entry.count;
    uint16_t end_speed = (uint16_t)(2u * steps - check->speed);
    int16_t change = (int16_t)(end_speed - check->speed);

    return end_speed <= check->easy_speed && check->speed <= check->easy_speed &&
           (change == 0 || (entry.repeat == 1u && entry.count != check->last_count &&
                            !too_steep(limits, change)));
}

// True for a segment that needs no closer look: it goes on in the direction of the last steps, and
// slowly enough. Zero and the other direction are far above every easy speed.
static inline bool is_easy(const struct line_check *check,
                           const struct line_limits *limits,
                           struct segment entry)
{
    uint16_t steps = (uint16_t)entry.count;

    if (check->smooth) {
        return (uint16_t)(steps - 1u) < check->easy_speed &&
               is_easy_curve(check, limits, entry);
    }
    steps = check->direction < 0 ? (uint16_t)-steps : steps;
    return (uint16_t)(steps - 1u) < check->easy_speed;
}

static inline void pass_segment(struct line_check *check, struct segment entry)
{
    check->last_count = entry.count;
    check->pixel += entry.repeat;
}

static enum line_error check_segment(struct line_check *check,
                                     const struct line_limits *limits,
                                     struct segment entry)
{
    enum line_error error = check_closely(check, limits, entry);

    if (error == LINE_none) {
        check->begun = true;
        pass_segment(check, entry);
    }
    return error;
}

// Check an entry in front of the segments.
static enum line_error APART check_head(struct line_check *check,
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

// Check an entry of any kind. Apart from the easy ones, which then need no registers saved.
static enum line_error APART check_entry(struct line_check *check,
                                         const struct line_limits *limits,
                                         struct segment entry)
{
    if (check->phase != LINE_CHECK_SEGMENTS) {
        return check_head(check, limits, entry);
    }
    return entry.repeat == 0 ? check_mark(check, entry)
                             : check_segment(check, limits, entry);
}

void line_check_limits(struct line_check *check, const struct line_limits *limits)
{
    BY_POINTER_SMALL(check);
    check->easy_speed = 0;
    if (check->phase == LINE_CHECK_SEGMENTS) {
        note_top_speed(check, limits);
    }
}

enum line_error line_check_entry(struct line_check *check,
                                 const struct line_limits *limits,
                                 struct segment entry)
{
    BY_POINTER_SMALL(check);
    if (entry.repeat == 0 || !is_easy(check, limits, entry)) {
        return check_entry(check, limits, entry);
    }
    if (check->smooth) {
        check->speed = (uint16_t)(2u * (uint16_t)entry.count - check->speed);
    }
    check->rest_ticks = 0;
    pass_segment(check, entry);
    return LINE_none;
}
