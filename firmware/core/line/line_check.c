// SPDX-License-Identifier: MIT
#include "line/line_check.h"

#include "base/apart.h"       // APART
#include "base/multiply.h"    // multiply_u32_u16
#include "line/line_speeds.h" // line_speeds_*

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
    line_speeds_note(check, steps_of(entry));
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
    uint8_t root = 1; // of LINE_COUNT_MAX: 128

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
    return line_speeds_too_fast(first_speed(check, entry),
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

    if (line_check_has_backlash(check)) {
        easy =
            check->reached ? check->line_speed : 0; // a speed that was reached is allowed
    }
    easy = lesser(easy, line_speeds_fastest(check));
    check->easy_speed = lesser(easy, LINE_COUNT_MAX);
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
    line_speeds_note(check, top);
    if (line_check_has_backlash(check)) {
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
    // Twice the count and the speed are both at most 2 * LINE_COUNT_MAX, so that 16 bits hold the
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
    if (!check->begun && entry.count == 0 && !line_check_has_backlash(check)) {
        note_warning(check, LINE_idle_pixel);
    }
    return error;
}

// Check the end mark of a line, or the down mark of a seek.
static enum line_error check_mark(struct line_check *check, struct segment entry)
{
    if (line_check_seeks(check) && (uint16_t)entry.count == LINE_MARK_DOWN) {
        check->seek = false;
        return LINE_none;
    }
    if (line_check_seeks(check) || (uint16_t)entry.count != LINE_MARK_END) {
        return LINE_malformed;
    }
    if (check->smooth && check->speed != 0) {
        return LINE_ends_moving;
    }
    if (line_check_has_backlash(check) && !check->reached) {
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

    if (entry.count > LINE_COUNT_MAX || entry.count < -LINE_COUNT_MAX) {
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

// Check an entry of any kind. Apart from the easy ones, which then need no registers saved.
static enum line_error APART check_entry(struct line_check *check,
                                         const struct line_limits *limits,
                                         struct segment entry)
{
    if (check->phase != LINE_CHECK_SEGMENTS) {
        return line_check_head(check, limits, entry);
    }
    return entry.repeat == 0 ? check_mark(check, entry)
                             : check_segment(check, limits, entry);
}

void line_check_limits(struct line_check *check, const struct line_limits *limits)
{
    BY_POINTER_SMALL(check);
    check->easy_speed = 0;
    if (check->phase == LINE_CHECK_SEGMENTS) {
        line_speeds_allow(check, limits);
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

#if SEVERAL_AXES
// Whether entries of one byte, or of two, are easy is told by one number: the steps of a pixel less
// one, in the direction of the line, are below easy_speed. For a count of the other direction, or
// 0, the number is too large.
static inline uint16_t number_of(uint16_t count, bool negative)
{
    return negative ? (uint16_t)~count : (uint16_t)(count - 1u);
}

static inline uint16_t next_number(uint16_t number, uint16_t more, bool negative)
{
    return negative ? (uint16_t)(number - more) : (uint16_t)(number + more);
}

static inline uint16_t count_of(uint16_t number, bool negative)
{
    return negative ? (uint16_t)~number : (uint16_t)(number + 1u);
}

// So many pixels were easy, up to one of this count.
static inline void note_easy(struct line_check *check, int16_t count, uint16_t pixels)
{
    check->last_count = count;
    check->pixel += pixels;
    check->rest_ticks = 0;
}

// Pass entries of one byte. Returns how many.
static inline uint8_t pass_near(
    const uint8_t *at, uint8_t left, uint16_t *number, uint16_t easy_speed, bool negative)
{
    const uint8_t *from = at;
    uint16_t newest = *number;

    while (left != 0 && *at <= SEGMENT_NEAR_LAST) {
        uint16_t next =
            next_number(newest, (uint16_t)(*at - SEGMENT_NEAR_ZERO), negative);
        if (next >= easy_speed) {
            break;
        }
        newest = next;
        at++;
        left--;
    }
    *number = newest;
    return (uint8_t)(at - from);
}

void line_check_pass_easy(struct line_check *check,
                          struct segment_reader *reader,
                          uint8_t size)
{
    bool negative = check->direction < 0;
    uint16_t number = number_of((uint16_t)reader->last, negative);
    const uint8_t *at = &reader->bytes[reader->at];
    uint8_t left = (uint8_t)(size - (uint8_t)reader->at);
    uint16_t pixels = 0;

    if (check->phase != LINE_CHECK_SEGMENTS || check->smooth) {
        return;
    }
    for (;;) {
        uint8_t near = pass_near(at, left, &number, check->easy_speed, negative);
        at += near;
        left = (uint8_t)(left - near);
        pixels = (uint16_t)(pixels + near);
        // A run of two bytes?
        if (left < 2u || at[0] <= SEGMENT_NEAR_LAST || at[0] >= SEGMENT_RUN) {
            break;
        }
        uint16_t next = next_number(number, (uint16_t)(int8_t)at[1], negative);
        if (next >= check->easy_speed) {
            break;
        }
        number = next;
        pixels = (uint16_t)(pixels + (uint8_t)(at[0] - SEGMENT_SHORT_RUN));
        at += 2;
        left = (uint8_t)(left - 2u);
    }
    if (pixels != 0) {
        reader->at = (uint8_t)(size - left);
        reader->last = (int16_t)count_of(number, negative);
        note_easy(check, reader->last, pixels);
    }
}
#endif
