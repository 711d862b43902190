// SPDX-License-Identifier: MIT
#include "motion/axis.h"

#include "base/apart.h" // APART

// Entries that must be free for a round of decoding to begin: a few steps at a time would cost more
// in getting there than in decoding.
#define DECODE_ROOM 64u
// And with fewer a round ends.
#define DECODE_ROOM_LEFT 32u
// A round of decoding must stay short: the serial line and line starts wait for it. Costs in units
// of a step of a flat curve, about 60 cycles.
#define STEEP_STEP_SHIFT 1u
#define SLOW_STEP_COST   12u
// Shorter stretches of evenly spaced steps are not worth a run,
#define RUN_MIN_STEPS 16u
// unless their intervals are: below this one, ticks, the step interrupt cannot take up a run behind
// a single period in time, only behind another run.
#define RUN_ENTRY_MIN_TICKS 160u
// The next run waits for one of the two to be free if the newer one is as long as this, time enough
// for the main loop to come by. Else single periods follow it for the time being.
#define RUN_WAIT_TICKS ((uint32_t)0x10000)
// A seek is decoded no further ahead than this (8 ms, several rounds of the main loop): what stands
// in the ring is made even if its switch trips.
#define SEEK_AHEAD_TICKS ((uint32_t)0x20000)
// Steps of a curve that are decoded and published together: at most, and while the ring runs low.
// The ledger takes what was decoded together as a whole, so that much of the ring may lie idle.
#define CURVE_BATCH     (FEED_BLOCKS > 0 ? 60u : 120u)
#define CURVE_BATCH_LOW 16u

void axis_init(struct axis *axis,
               struct step_ring *ring,
               struct run *slots,
               uint8_t slot_count,
               uint16_t first_period_ticks)
{
    *axis = (struct axis){.state = AXIS_EMPTY};
    run_queue_init(&axis->queue, slots, slot_count);
    line_check_reset(&axis->check);
    feed_reset(&axis->feed, ring, 0);
    ledger_reset(&axis->ledger, ring, first_period_ticks);
}

static APART struct run run_from_bytes(const uint8_t *bytes)
{
    return (struct run){
        .count = (int16_t)(((uint16_t)bytes[0] << 8) | bytes[1]),
        .repeat = (uint16_t)(((uint16_t)bytes[2] << 8) | bytes[3]),
    };
}

// True when every entry is possible after what is queued; the check then stands behind the block.
static bool check_block(struct axis *axis,
                        const struct line_limits *limits,
                        const uint8_t *entries,
                        uint8_t count,
                        uint8_t *whole_lines)
{
    // At rest there is no line to follow without a gap: any direction may come next.
    if (axis->state == AXIS_EMPTY || axis->state == AXIS_DONE) {
        line_check_reset(&axis->check);
    }
    struct line_check check = axis->check;

    for (uint8_t i = 0; i < count; i++) {
        enum line_error error =
            line_check_entry(&check, limits, run_from_bytes(&entries[4u * i]));
        if (error != LINE_none) {
            axis->line_error = (uint8_t)error;
            axis->line_error_pixel = check.pixel + 1u;
            return false;
        }
        if (check.phase == LINE_CHECK_OUTSIDE) {
            (*whole_lines)++;
        }
    }
    axis->check = check;
    axis->line_warning = check.warning;
    return true;
}

// A line longer than the memory may start when most of the memory is full.
static void update_loaded(struct axis *axis)
{
    if (axis->state > AXIS_LOADED && axis->state != AXIS_DONE) {
        return;
    }
    if (axis->whole_lines != 0 || run_queue_free(&axis->queue) <= axis->queue.mask / 4u) {
        axis->state = AXIS_LOADED;
    } else if (run_queue_fill(&axis->queue) != 0) {
        axis->state = AXIS_LOADING;
    }
}

enum block_result axis_queue_block(struct axis *axis,
                                   const struct line_limits *limits,
                                   uint16_t block,
                                   const uint8_t *entries,
                                   uint8_t count)
{
    uint8_t whole_lines = 0;

    if (axis->any_block && block == (uint16_t)(axis->next_block - 1u)) {
        return BLOCK_REPEATED;
    }
    if (block != axis->next_block) {
        return BLOCK_WRONG;
    }
    if (axis->state >= AXIS_REFUSED) {
        return BLOCK_REFUSED;
    }
    if (run_queue_free(&axis->queue) < count) {
        return BLOCK_FULL;
    }
    if (!check_block(axis, limits, entries, count, &whole_lines)) {
        // An armed or running line runs dry and says so, unless a better block comes in time; one
        // that is neither never starts.
        if (axis->state < AXIS_ARMED || axis->state == AXIS_DONE) {
            axis->state = AXIS_REFUSED;
        }
        return BLOCK_REFUSED;
    }
    for (uint8_t i = 0; i < count; i++) {
        (void)run_queue_push(&axis->queue, run_from_bytes(&entries[4u * i]));
    }
    axis->whole_lines = (uint8_t)(axis->whole_lines + whole_lines);
    axis->next_block++;
    axis->any_block = true;
    axis->dry = false;
    update_loaded(axis);
    return BLOCK_TAKEN;
}

// The start mark's word, when it is in front.
static uint16_t front_word(const struct axis *axis)
{
    struct run mark = {0};

    (void)run_queue_peek(&axis->queue, 0, &mark);
    return (uint16_t)mark.count;
}

bool axis_waits_for_edge(const struct axis *axis)
{
    return (front_word(axis) & RUN_START_WAIT) != 0;
}

bool axis_seeks(const struct axis *axis, bool *opening)
{
    uint16_t word = front_word(axis);

    *opening = (word & RUN_START_OPEN) != 0;
    return (word & RUN_START_SEEK) != 0;
}

static bool start_queued(const struct axis *axis)
{
    struct run mark;

    return run_queue_peek(&axis->queue, 0, &mark) && mark.repeat == 0 &&
           ((uint16_t)mark.count & RUN_MARK_KIND) == RUN_MARK_START &&
           run_queue_fill(&axis->queue) > 1u;
}

static void begin_line(struct axis *axis,
                       const struct pixel_period *period,
                       bool always_take_up)
{
    bool negative = (front_word(axis) & RUN_START_NEGATIVE) != 0;
    bool reverses = !axis->direction_known || negative != axis->feed.negative;

    line_begin(&axis->line, period, &axis->queue, always_take_up || reverses);
    axis->in_line = true;
    axis->walking = false;
    axis->awaits_run = false;
    axis->edge_due = false;
    axis->dry = false;
    feed_mark_here(&axis->feed, true, 0);
}

bool axis_arm(struct axis *axis, const struct pixel_period *period, bool always_take_up)
{
    if (axis->state != AXIS_LOADED || !start_queued(axis)) {
        return false;
    }
    feed_hold(&axis->feed);
    begin_line(axis, period, always_take_up);
    axis->ledger.pixel = 0; // a fault before the line's first step is in its first pixel
    axis->state = AXIS_ARMED;
    return true;
}

void axis_discard(struct axis *axis, uint8_t ring_slot)
{
    run_queue_clear(&axis->queue);
    line_check_reset(&axis->check);
    axis->whole_lines = 0;
    axis->in_line = false;
    axis->walking = false;
    axis->awaits_run = false;
    axis->dry = false;
    feed_reset(&axis->feed, axis->feed.ring, ring_slot);
    axis->feed.negative = axis->ledger.negative;
    // A run's rest was cut off and accounted for before: ledger_follow() sees the cut.
    ledger_skip_to(&axis->ledger, ring_slot);
    axis->feed.written_ticks = axis->ledger.taken_ticks;
    axis->state = AXIS_EMPTY;
}

void axis_line_finished(struct axis *axis)
{
    axis->lines_done++;
    axis->state = AXIS_DONE;
    update_loaded(axis);
}

// A queued line that does not wait for the clock follows at once. Seeks stand alone: their switch
// is watched from arming to rest.
static bool chains(const struct axis *axis)
{
    return start_queued(axis) && !axis->line.seek &&
           (front_word(axis) & (RUN_START_WAIT | RUN_START_SEEK)) == 0;
}

// The line is decoded to its end.
static void finish_line(struct axis *axis,
                        const struct pixel_period *period,
                        bool always_take_up)
{
    if (axis->whole_lines != 0) {
        axis->whole_lines--;
    }
    axis->direction_known = true;
    if (chains(axis)) {
        axis->lines_done++;
        begin_line(axis, period, always_take_up);
        return;
    }
    feed_end(&axis->feed);
    axis->in_line = false;
}

static void begin_piece(struct axis *axis)
{
    const struct piece *piece = &axis->piece;

    if (piece->steps == 0) {
        feed_quiet(&axis->feed, piece->ticks);
        axis->edge_due = piece->has_edge;
        return;
    }
    if (piece->has_edge && piece->edge_steps == 0) {
        feed_mark_here(&axis->feed, false, piece->edge_position);
    }
    walk_start(&axis->walk, piece);
    axis->walking = true;
}

uint32_t axis_ahead_ticks(const struct axis *axis)
{
    uint32_t ahead = axis->feed.written_ticks - axis->ledger.taken_ticks;

    if (axis->ledger.run != LEDGER_NO_RUN) {
        ahead -= (uint32_t)ledger_run_loaded(&axis->ledger) *
                 feed_run_base(&axis->feed, axis->ledger.run);
    }
    return ahead;
}

// The piece in work is the last for now.
static bool no_more_pieces(const struct axis *axis)
{
    return feed_marks_full(&axis->feed) ||
           (axis->line.seek && axis_ahead_ticks(axis) > SEEK_AHEAD_TICKS);
}

// False when nothing can be decoded now. Not inline: its registers would lie on the stack below the
// decoder of steps.
static bool __attribute__((noinline)) next_piece(struct axis *axis,
                                                 const struct pixel_period *period,
                                                 bool always_take_up)
{
    if (no_more_pieces(axis)) {
        return false;
    }
    switch (line_next(&axis->line, &axis->piece)) {
    case LINE_PIECE:
        begin_piece(axis);
        return true;
    case LINE_OVER:
        finish_line(axis, period, always_take_up);
        return true;
    case LINE_DRY:
    default:
        axis->dry = true;
        return false;
    }
}

// Steps that must pass before the piece may become a run.
static uint8_t to_stagger(const struct axis *axis)
{
    uint16_t taken = walk_taken(&axis->walk);

    return taken >= axis->stagger ? 0 : (uint8_t)(axis->stagger - taken);
}

// The steps to come are a run for the interrupt to carry.
static bool run_due(const struct axis *axis)
{
    const struct even *even = &axis->walk.steps.even;
    uint16_t steps = walk_stretch(&axis->walk);

    return axis->walking && !axis->walk.curved && !axis->edge_due &&
           !feed_busy(&axis->feed) && feed_steady(&axis->feed, axis->piece.negative) &&
           steps != 0 &&
           (steps >= RUN_MIN_STEPS || even->base_ticks < RUN_ENTRY_MIN_TICKS) &&
           to_stagger(axis) == 0 && feed_can_carry(&axis->feed, even);
}

// A run is due but none is free, and there is time to wait for one.
static bool run_awaited(const struct axis *axis)
{
    const struct feed *feed = &axis->feed;

    return !feed_run_free(feed) && run_due(axis) &&
           (axis->walk.steps.even.base_ticks < RUN_ENTRY_MIN_TICKS ||
            feed->runs[feed->newest_run].ticks >= RUN_WAIT_TICKS);
}

bool axis_decoded(const struct axis *axis)
{
    if (!axis->in_line || axis->dry ||
        feed_space(&axis->feed, axis->ledger.retired) < DECODE_ROOM) {
        return true;
    }
    if (axis->awaits_run) {
        return !feed_run_free(&axis->feed);
    }
    return !axis->walking && !axis->edge_due && !feed_busy(&axis->feed) &&
           no_more_pieces(axis);
}

// Hand as many of the steps to come as the ring has room for to the interrupt.
static void decode_run(struct axis *axis)
{
    uint8_t room = (uint8_t)(feed_space(&axis->feed, axis->ledger.retired) - FEED_BURST);
    uint16_t fit = (uint16_t)((room + 1u) * STEP_RUN_ENTRY_MAX);
    uint16_t steps = walk_stretch(&axis->walk);
    struct even even = axis->walk.steps.even;

    if (steps > fit) {
        steps = fit;
    }
    feed_run(&axis->feed, &even, steps, walk_skip_even(&axis->walk, steps));
    axis->edge_due = axis->walk.at_edge;
    axis->walking = !walk_done(&axis->walk);
}

// Ordinary steps, evenly spaced: a whole burst with everything in registers.
static uint32_t burst_even(struct axis *axis, uint8_t count)
{
    struct step_ring *ring = axis->feed.ring;
    struct even even = axis->walk.steps.even;
    uint8_t slot = axis->feed.head;
    uint32_t sum = 0;

    for (; count != 0; count--) {
        uint32_t ticks = even_next(&even);
        sum += ticks;
        slot = feed_burst_put(ring, slot, (uint16_t)ticks);
    }
    axis->walk.steps.even.sum = even.sum;
    feed_note_block(&axis->feed, axis->feed.head, (uint8_t)(slot - axis->feed.head), sum);
    axis->feed.head = slot;
    return sum;
}

// Ordinary steps of a curve, up to `count`, as long as the decoder's fast path finds them. They
// become visible all at once: the sentinel behind them, then the first one's high byte.
static uint32_t burst_curve(struct axis *axis, uint8_t *count)
{
    struct step_ring *ring = axis->feed.ring;
    uint8_t slot = axis->feed.head;
    uint8_t fill = axis_ring_fill(axis);
    uint8_t most = fill < CURVE_BATCH_LOW ? CURVE_BATCH_LOW : fill;
    struct curve_made made;

    if (most > CURVE_BATCH) {
        most = CURVE_BATCH;
    }
    curve_burst(
        &axis->walk.steps.curve, ring, slot, *count < most ? *count : most, &made);
    *count = made.steps;
    if (made.steps == 0) {
        return 0;
    }
    axis->feed.head = (uint8_t)(slot + made.steps);
    ring->high[axis->feed.head] = STEP_HIGH_EMPTY;
    ring->high[slot] = made.first_high;
    feed_note_block(&axis->feed, slot, made.steps, made.ticks);
    return made.ticks;
}

// The cost of a step is 2 to this power.
static uint8_t cost_shift(const struct axis *axis)
{
    return axis->walk.curved && axis->walk.steps.curve.kind == CURVE_FLAT_NOT
               ? STEEP_STEP_SHIFT
               : 0;
}

// Ordinary steps that budget, space and the walk allow.
static uint8_t burst_size(const struct axis *axis, uint8_t budget, uint8_t shift)
{
    uint8_t room = (uint8_t)(feed_space(&axis->feed, axis->ledger.retired) - FEED_BURST);
    uint16_t steps = walk_burst(&axis->walk);
    uint8_t count = (uint8_t)(budget >> shift);

    if (count == 0) {
        count = 1;
    }
    if (room < count) {
        count = room;
    }
    if (steps < count) {
        count = (uint8_t)steps;
    }
    return count;
}

// As many of them as can be had; what they cost.
static uint8_t decode_burst(struct axis *axis, uint8_t budget)
{
    uint8_t shift = cost_shift(axis);
    uint8_t count = burst_size(axis, budget, shift);
    uint32_t ticks = 0;

    if (count == 0 || !feed_plain(&axis->feed, axis->piece.negative)) {
        return 0;
    }
    if (axis->walk.curved) {
        ticks = burst_curve(axis, &count);
    } else if (axis->walk.steps.even.base_ticks < STEP_PERIOD_MAX_TICKS) {
        uint8_t stagger = to_stagger(axis);
        if (stagger != 0 && stagger < count) {
            count = stagger;
        }
        ticks = burst_even(axis, count);
    } else {
        return 0;
    }
    walk_skip(&axis->walk, count, ticks);
    return (uint8_t)(count << shift);
}

// One step, special or ordinary. Returns what it cost of a round's budget: long intervals of a
// curve come from the decoder's slow path.
static uint8_t decode_step(struct axis *axis)
{
    uint32_t ticks = walk_next(&axis->walk);

    feed_step(&axis->feed, ticks, axis->piece.negative);
    axis->edge_due = axis->walk.at_edge;
    axis->walking = !walk_done(&axis->walk);
    return axis->walk.curved ? SLOW_STEP_COST : 1u;
}

static uint8_t decode_steps(struct axis *axis, uint8_t budget)
{
    if (run_due(axis) && feed_run_free(&axis->feed)) {
        decode_run(axis);
        return SLOW_STEP_COST;
    }
    uint8_t cost = decode_burst(axis, budget);

    return cost != 0 ? cost : decode_step(axis);
}

uint8_t axis_decode(struct axis *axis,
                    const struct pixel_period *period,
                    bool always_take_up,
                    uint8_t budget)
{
    axis->awaits_run = false;
    while (budget != 0 && axis->in_line &&
           feed_space(&axis->feed, axis->ledger.retired) >= DECODE_ROOM_LEFT) {
        uint8_t cost = 1;
        if (feed_busy(&axis->feed)) {
            feed_pump(&axis->feed);
        } else if (axis->edge_due) {
            feed_mark_here(&axis->feed, false, axis->piece.edge_position);
            axis->edge_due = false;
            feed_make_room(&axis->feed);
        } else if (axis->walking) {
            if (run_awaited(axis)) {
                axis->awaits_run = true;
                break;
            }
            cost = decode_steps(axis, budget);
        } else if (!next_piece(axis, period, always_take_up)) {
            break;
        }
        budget = budget > cost ? (uint8_t)(budget - cost) : 0;
    }
    return budget;
}
