// SPDX-License-Identifier: MIT
#include "axis/axis.h"

#include "base/apart.h"     // APART
#include "base/interlude.h" // interlude

#if FEATURE_LINE_ENDS
static struct axis *company;
static uint8_t company_size;
static bool held;      // no line begins that none of the company has begun
static bool held_back; // a line that was queued

void axis_company(struct axis *axes, uint8_t count)
{
    company = axes;
    company_size = count;
    held = false;
    held_back = false;
}

void axis_hold(bool hold)
{
    held = hold;
}

bool axis_take_held(void)
{
    bool was = held_back;

    held_back = false;
    return was;
}

// Axes that are armed while no other one moves are a new company.
static void leave_company(const struct axis *axis)
{
    for (uint8_t i = 0; i < company_size; i++) {
        if (&company[i] != axis && lifecycle_moving(&company[i].life)) {
            return;
        }
    }
    for (uint8_t i = 0; i < company_size; i++) {
        company[i].joint = false;
    }
}

static bool front_says_more(const struct axis *axis)
{
    return (segment_queue_front_word(&axis->queue) & LINE_START_MORE) != 0;
}

// True when so many lines are queued behind the one in work, the last of them at least in part.
static bool has_queued(const struct axis *axis, uint8_t lines)
{
    bool part = axis->check.phase == LINE_CHECK_SEGMENTS && axis->check.begun;

    return axis->phase != DECODE_OUTSIDE &&
           (uint8_t)(axis->whole_lines + (part ? 1u : 0u)) > lines;
}

// The axis has come to the end of its line, and no line follows that has to.
static void name_late(struct axis *axis)
{
    axis->line_error = LINE_none_followed;
    axis->line_error_pixel = 0;
}

// True when another axis of the company has the line, `lines` lines behind its own, in its queue.
static bool can_follow(struct axis *other, uint8_t lines)
{
    if (!other->more || has_queued(other, lines)) {
        return true;
    }
    // An axis that has ended was named then, or another one was.
    if (other->phase != DECODE_OUTSIDE) {
        name_late(other);
    }
    return false;
}

// True when the axis, whose next line is queued, may begin it.
static bool may_go_on(const struct axis *axis)
{
    bool ready = !held;

    for (uint8_t i = 0; axis->joint && i < company_size; i++) {
        struct axis *other = &company[i];
        int8_t lines = (int8_t)(axis->lines_begun + 1u - other->lines_begun);

        if (other == axis || !other->joint) {
            continue;
        }
        if (lines <= 0) {
            return true; // all of them could begin it then
        }
        ready = can_follow(other, (uint8_t)lines) && ready;
    }
    return ready;
}

// The axis ends; follows: its next line is queued.
static void note_end(struct axis *axis, bool follows)
{
    if (follows) {
        held_back = held_back || held;
    } else if (axis->more) {
        name_late(axis);
    }
}
#else
static inline bool may_go_on(const struct axis *axis)
{
    (void)axis;
    return true;
}

static inline void note_end(struct axis *axis, bool follows)
{
    (void)axis;
    (void)follows;
}
#endif

// Discard what is written and not made. slot: where the step interrupt reads next.
static void empty_stream(struct axis *axis, uint8_t slot)
{
    feed_reset(&axis->feed, slot, axis->ledger.negative, axis->ledger.loaded_ticks);
}

void axis_init(struct axis *axis, const struct axis_parts *parts)
{
    *axis = (struct axis){0};
#if SEVERAL_AXES
    axis->stagger = parts->stagger & 15u;
#endif
    lifecycle_reset(&axis->life);
    segment_queue_init(&axis->queue, parts->queue_bytes, parts->queue_size);
    line_check_reset(&axis->check);
    axis->feed.stream.ring = parts->ring;
    axis->feed.stream.engine_trains = parts->trains;
    ledger_reset(&axis->ledger, parts->first_period_ticks);
    empty_stream(axis, 0);
}

// Read the block's next entry. Returns false when the block ends inside the entry, or when a
// mark or a parameter in front of a line's pixels is not in full.
static bool read_entry(const struct block *block,
                       struct segment_reader *reader,
                       const struct line_check *check,
                       struct segment *entry)
{
    uint8_t at = (uint8_t)reader->at;
    uint8_t first = block->bytes[at];

    if (!block->packed) {
        block->bytes[at] = first | SEGMENT_IN_FULL;
        *entry = segment_unpack(reader);
        // A count of 16 bits, which the check may have to refuse.
        entry->count = (int16_t)((uint16_t)first << 8 | block->bytes[at + 1u]);
        return true;
    }

    if (segment_packed_size(first) > (uint8_t)(block->size - at) ||
        (check->phase != LINE_CHECK_SEGMENTS && first < SEGMENT_IN_FULL)) {
        return false;
    }
    *entry = segment_unpack(reader);
    if (check->phase == LINE_CHECK_PARAMETER) {
        entry->count = (int16_t)((uint16_t)entry->count & SEGMENT_PARAMETER);
    }
    return true;
}

// An axis at rest has no line that the new one could follow without a pause: any direction may come
// next.
static bool begins_anew(const struct axis *axis)
{
    return axis->life.state == AXIS_EMPTY || axis->life.state == AXIS_DONE;
}

// Entries that are checked between two interludes: one may take 680 cycles.
#define CHECKED_AT_ONCE 3u
// Bytes of easy entries, at 30 cycles each.
#define PASSED_AT_ONCE 36u
// To append a longer block takes some time, too.
#define LONG_BYTES 80u

static inline uint8_t end_of_part(const struct block *block,
                                  const struct segment_reader *reader)
{
    bool goes_on =
        SEVERAL_AXES && (uint8_t)(block->size - (uint8_t)reader->at) > PASSED_AT_ONCE;

    return goes_on ? (uint8_t)(reader->at + PASSED_AT_ONCE) : block->size;
}

// Check as many entries as may be checked at once. Returns the error of the first one that is not
// possible.
static inline enum line_error check_some(struct line_check *check,
                                         const struct line_limits *limits,
                                         const struct block *block,
                                         struct segment_reader *reader,
                                         uint8_t *whole_lines)
{
    uint8_t end = end_of_part(block, reader);
    uint8_t checked = 0;

    // The last entry may go beyond `end`.
    while (reader->at < end && (!SEVERAL_AXES || checked < CHECKED_AT_ONCE)) {
        struct segment entry;
#if SEVERAL_AXES
        if (block->packed) {
            line_check_pass_easy(check, reader, end);
        }
        if (reader->at == end) {
            break;
        }
#endif
        if (!read_entry(block, reader, check, &entry)) {
            return LINE_malformed;
        }
        enum line_error error = line_check_entry(check, limits, entry);
        if (error != LINE_none) {
            return error;
        }
        if (check->phase == LINE_CHECK_OUTSIDE) {
            (*whole_lines)++;
        }
        checked++;
    }
    return LINE_none;
}

static inline bool is_long(const struct block *block)
{
    return SEVERAL_AXES && block->size > LONG_BYTES;
}

// Let the axes be looked after. Returns false when the block must come again: the axis has failed
// meanwhile, or its lines were discarded.
static inline bool pause_check(const struct axis *axis)
{
    uint8_t before = axis->life.state;

    interlude();
    uint8_t state = axis->life.state;

    // The image's interlude() changes it; cppcheck sees the empty one.
    // cppcheck-suppress knownConditionTrueFalse
    return state == before || !(state == AXIS_EMPTY || state == AXIS_STOPPING ||
                                state == AXIS_REFUSED || state == AXIS_FAULT);
}

// Check every entry after the queued ones. If the block is taken, the axis's check has passed the
// whole block, and *reader has read all of it.
static enum block_result check_block(struct axis *axis,
                                     const struct line_limits *limits,
                                     const struct block *block,
                                     struct segment_reader *reader,
                                     uint8_t *whole_lines)
{
    if (begins_anew(axis)) {
        line_check_reset(&axis->check);
    }
    struct line_check check = axis->check;
    bool goes_on = false;

    do {
        enum line_error error = check_some(&check, limits, block, reader, whole_lines);
        if (error != LINE_none) {
            axis->line_error = (uint8_t)error;
            axis->line_error_pixel = check.pixel + 1u;
            return BLOCK_REFUSED;
        }
        goes_on = SEVERAL_AXES && reader->at < block->size;
        // cppcheck-suppress knownConditionTrueFalse
        if ((goes_on || is_long(block)) && !pause_check(axis)) {
            return BLOCK_FULL;
        }
    } while (goes_on);
    axis->check = check;
    axis->line_warning = check.warning;
    return BLOCK_TAKEN;
}

// Report that the axis may be armed: when the queue holds a whole line, or when most of the queue
// is full, since a line may be longer than the queue.
static void report_queue(struct axis *axis)
{
    if (axis->whole_lines != 0 ||
        segment_queue_free(&axis->queue) <= axis->queue.out.mask / 4u) {
        (void)lifecycle_report(&axis->life, LIFECYCLE_READY);
    } else if (segment_queue_fill(&axis->queue) != 0) {
        (void)lifecycle_report(&axis->life, LIFECYCLE_QUEUED);
    }
}

// Decide whether this block may be checked and queued. BLOCK_TAKEN means that it may.
static enum block_result admit_block(const struct axis *axis, const struct block *block)
{
    BY_POINTER_SMALL(axis);
    // The queue will be discarded as soon as the axis is at rest.
    if (axis->life.state == AXIS_STOPPING) {
        return BLOCK_FULL;
    }
    if (axis->any_block && block->number == (uint16_t)(axis->next_block - 1u)) {
        return BLOCK_REPEATED;
    }
    if (block->number != axis->next_block) {
        return BLOCK_WRONG;
    }
    if (axis->life.state == AXIS_REFUSED || axis->life.state == AXIS_FAULT) {
        return BLOCK_REFUSED;
    }
    return segment_queue_free(&axis->queue) < block->size ? BLOCK_FULL : BLOCK_TAKEN;
}

#if FEATURE_LINE_DIVIDER
// The first word of the entry at this byte.
static uint16_t word_at(const struct block *block, uint8_t at)
{
    struct segment_reader reader = {.bytes = block->bytes, .mask = UINT16_MAX, .at = at};

    if (block->packed) {
        return (uint16_t)segment_unpack(&reader).count;
    }
    return (uint16_t)((uint16_t)block->bytes[at] << 8 | block->bytes[at + 1u]);
}

// The block's first entry is a start mark, if it is one, that promises a divider.
static bool start_divides(const struct block *block)
{
    return (word_at(block, 0) & LINE_START_DIVIDER) != 0;
}

// Entries of a block in front of the divider, each of them four bytes; UINT8_MAX: it brings none
// that may change the setting.
static uint8_t entries_before_divider(const struct axis *axis, const struct block *block)
{
    const struct line_check *check = &axis->check;
    bool fresh = begins_anew(axis);

    if (fresh || check->phase == LINE_CHECK_OUTSIDE) {
        return start_divides(block) && (fresh || (check->flags & LINE_CHECK_BEHIND) == 0)
                   ? 2
                   : UINT8_MAX;
    }
    if (check->behind || !check->divided || check->phase == LINE_CHECK_SEGMENTS) {
        return UINT8_MAX;
    }
    return check->phase == LINE_CHECK_PARAMETER ? 1 : 0;
}

uint16_t axis_block_divider(const struct axis *axis, const struct block *block)
{
    if (admit_block(axis, block) != BLOCK_TAKEN) {
        return 0;
    }
    uint16_t at = (uint16_t)(SEGMENT_MOST * entries_before_divider(axis, block));

    return at + SEGMENT_MOST > block->size ? 0 : word_at(block, (uint8_t)at);
}
#endif

enum block_result axis_queue_block(struct axis *axis,
                                   const struct line_limits *limits,
                                   const struct block *block)
{
    struct segment_reader reader = {
        .bytes = block->bytes, .mask = UINT16_MAX, .last = axis->queue.last};
    uint8_t whole_lines = 0;
    enum block_result admitted = admit_block(axis, block);

    if (admitted != BLOCK_TAKEN) {
        return admitted;
    }
    line_check_limits(&axis->check, limits);
    admitted = check_block(axis, limits, block, &reader, &whole_lines);
    if (admitted == BLOCK_REFUSED) {
        // An armed or running line runs dry, which is a fault, unless a better block comes in time.
        // A line that is neither armed nor running never starts.
        (void)lifecycle_report(&axis->life, LIFECYCLE_REFUSE);
    }
    if (admitted != BLOCK_TAKEN) {
        return admitted;
    }
    segment_queue_append(&axis->queue, block->bytes, block->size, reader.last);
    axis->whole_lines = (uint8_t)(axis->whole_lines + whole_lines);
    axis->next_block++;
    axis->any_block = true;
    if (axis->phase == DECODE_DRY) {
        axis->phase = DECODE_PIECE;
    }
    report_queue(axis);
    return BLOCK_TAKEN;
}

bool axis_waits_for_edge(const struct axis *axis)
{
    uint8_t flags = (uint8_t)segment_queue_front_word(&axis->queue);

    BY_BYTE(flags);
    return (flags & LINE_START_WAIT) != 0;
}

bool axis_seeks(const struct axis *axis, bool *opening)
{
    uint16_t word = segment_queue_front_word(&axis->queue);
    uint8_t flags = (uint8_t)word;
    uint8_t more = (uint8_t)(word >> 8);

    BY_BYTE(flags);
    BY_BYTE(more);
    *opening = (more & LINE_START_OPEN >> 8) != 0;
    return (flags & LINE_START_SEEK) != 0;
}

// Wherever this is asked, a start mark is the next entry that may be queued. All entries in front
// of a line's segments are in full, so that what is behind the first two of them, however short,
// is a whole divider or none is due.
static bool start_queued(const struct axis *axis)
{
    return segment_queue_fill(&axis->queue) > LINE_HEAD_ENTRIES * SEGMENT_MOST;
}

// What the steps before a line have taken up of the play.
enum before {
    // The ledger tells: all of the steps are made.
    BEFORE_MADE,
    // All of it: they end with a line that has backlash, the same as the next one.
    BEFORE_ALL,
    // Nobody knows: they end with another line, which is not made yet.
    BEFORE_UNKNOWN,
};

// Let the line that was begun take up what is lacking of its backlash.
static APART void begin_play(struct axis *axis, enum before before)
{
    struct line *line = &axis->line;
    struct ledger *ledger = &axis->ledger;
    BY_POINTER_SMALL(axis);
    BY_POINTER_SMALL(line);
    BY_POINTER_SMALL(ledger);
    uint16_t steps = line->backlash_steps;

    play_tell(&ledger->play, ledger_settle_play(ledger), steps);
    uint16_t lacking = ledger_settle_play(ledger);
    bool unknown = !play_known(&ledger->play);

    if (before != BEFORE_MADE) {
        lacking = steps;
        unknown = before != BEFORE_ALL;
    }
    // Up to here it is what is taken up in the direction of the steps before.
    if (line->source.negative == axis->feed.negative) {
        lacking = steps - lacking;
    }
    if (unknown) {
        lacking = steps;
    }
    axis->play_unknown = unknown;
    line->backlash_steps = lacking;
    if (lacking == 0) {
        line->source.shifted = false;
    }
}

static void axis_begin_line(struct axis *axis,
                            const struct pixel_period *period,
                            enum before before)
{
#if FEATURE_LINE_ENDS
    axis->more = front_says_more(axis);
#endif
    line_begin(&axis->line, period, &axis->queue);
    if (FEATURE_BACKLASH && axis->line.source.shifted) {
        begin_play(axis, before);
    }
    axis->phase = DECODE_PIECE;
    feed_mark_here(&axis->feed, true, 0);
}

bool axis_arm(struct axis *axis, const struct pixel_period *period)
{
    BY_POINTER_SMALL(axis);
    bool clocked = axis_waits_for_edge(axis) && !lock_grid_now()->ignored;

    if (!start_queued(axis) || !lifecycle_report(&axis->life, LIFECYCLE_ARM)) {
        return false;
    }
    axis->clocked = clocked;
    feed_hold(&axis->feed);
#if FEATURE_LINE_ENDS
    leave_company(axis);
    axis->line_error = LINE_none;
    axis->lines_begun = 0;
    axis->joint = front_says_more(axis);
#endif
    axis_begin_line(axis, period, BEFORE_MADE);
    if (clocked && lock_grid_now()->locks) {
        line_grid_start_locked(&axis->line.edges);
    }
    axis->ledger.pixel = 0; // a fault before the line's first step is in its first pixel
    return true;
}

void axis_place(struct axis *axis, uint32_t zero_ticks)
{
    if (lifecycle_report(&axis->life, LIFECYCLE_PLACED)) {
        axis->zero_ticks = zero_ticks;
    }
}

bool axis_released(struct axis *axis)
{
    return lifecycle_report(&axis->life, LIFECYCLE_RELEASED);
}

void axis_stop(struct axis *axis)
{
    axis->phase = DECODE_OUTSIDE;
    (void)lifecycle_report(&axis->life, LIFECYCLE_STOP);
}

void axis_fail(struct axis *axis)
{
    if (lifecycle_moving(&axis->life)) {
        axis->phase = DECODE_OUTSIDE;
    }
    (void)lifecycle_report(&axis->life, LIFECYCLE_FAIL);
}

void axis_discard(struct axis *axis, uint8_t ring_slot)
{
    segment_queue_clear(&axis->queue);
    line_check_reset(&axis->check);
    axis->whole_lines = 0;
    axis->phase = DECODE_OUTSIDE;
    // A pulse train that was cut off is accounted for already: ledger_advance() sees the cut.
    ledger_cut(&axis->ledger, &axis->feed.stream);
    empty_stream(axis, ring_slot);
    (void)lifecycle_report(&axis->life, LIFECYCLE_SETTLED);
}

void axis_line_finished(struct axis *axis)
{
    BY_POINTER_SMALL(axis);
    if (lifecycle_report(&axis->life, LIFECYCLE_FINISHED)) {
        axis->ledger.lines_done++;
        if (FEATURE_LINE_DIVIDER && !start_queued(axis)) {
            // Of the next line no more than its head is here: no line is in front of it any more.
            axis->check.behind = false;
        }
        report_queue(axis);
    }
}

// True when the next queued line follows at once, because it does not wait for the clock. A seek
// never follows another line and none follows it: its switch is watched from arming to rest.
static bool line_chains(const struct axis *axis)
{
    return start_queued(axis) && !segment_source_ends_early(&axis->line.source) &&
           (segment_queue_front_word(&axis->queue) &
            (LINE_START_WAIT | LINE_START_SEEK)) == 0;
}

void axis_line_decoded(struct axis *axis, const struct pixel_period *period)
{
    BY_POINTER_SMALL(axis);
    if (axis->whole_lines != 0) {
        axis->whole_lines--;
    }
    bool follows = line_chains(axis);
    if (follows && may_go_on(axis)) {
        // The grid goes on as it is, with its part of a tick.
        struct line_grid edges = axis->line.edges;

#if FEATURE_LINE_ENDS
        axis->lines_begun++;
#endif
        axis_begin_line(
            axis, period, axis->line.line_speed != 0 ? BEFORE_ALL : BEFORE_UNKNOWN);
        axis->line.edges = edges;
        return;
    }
    note_end(axis, follows);
    feed_end(&axis->feed);
    axis->phase = DECODE_OUTSIDE;
}
