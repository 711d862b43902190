// SPDX-License-Identifier: MIT
#include "axis/decode.h"

#include "base/apart.h"         // APART
#include "build_features.h"     // FEATURE_SHORT_CURVES, SEVERAL_AXES
#include "steps/curve_batch.h"  // curve_batch_*
#include "steps/curved_pixel.h" // curved_pixel_write
#include "steps/even_pixel.h"   // even_pixels_write
#include "steps/train_pixel.h"  // train_pixel_*

// Entries of the ring that must be free for a round of decoding to begin: with a few steps at a
// time the calls would cost more than the decoding.
#define DECODE_ROOM 40u
// With several axes inside a curve only: what all of them have in their rings is what the pieces
// that begin at one pixel edge may take.
#define DECODE_ROOM_PIECE (SEVERAL_AXES ? 64u : DECODE_ROOM)
_Static_assert(!SEVERAL_AXES || CURVED_PIXEL_MAX_STEPS <= DECODE_ROOM_PIECE,
               "nobody notes the room that a curved pixel waits for");
// A round of decoding ends when fewer entries than this are free.
#define DECODE_ROOM_LEFT 20u
_Static_assert(DECODE_ROOM_LEFT > FEED_BURST, "a step fits");
// A round of decoding must stay short: the bus and the starts of lines wait for it. Costs in units
// of a step of a flat curve, about 60 cycles.
#define STEEP_STEP_SHIFT (SEVERAL_AXES ? 2u : 1u)
#define CURVED_STEP_COST (SEVERAL_AXES ? 22u : 12u)
#define SLOW_STEP_COST   (SEVERAL_AXES ? 36u : 24u) // found by the slow path
#define TRAIN_COST       12u
// Even steps that are entries, with several axes: some 15 cycles for one.
#define SINGLES_COST(count) ((uint8_t)((count) / 4u + 1u))
#define PUMP_COST           6u // a part of a long interval, some 330 cycles
#define PIECE_COST          (SEVERAL_AXES ? 60u : 1u) // to begin a piece
#define TRAIN_PIXEL_COST    20u
// A seek is decoded no further ahead than this, ticks (8 ms, several rounds of the main loop),
// because all steps in the ring are made even if the switch trips.
#define SEEK_AHEAD_TICKS ((uint32_t)0x20000)

// LARGE: APART where there are several axes. What a large function keeps in memory would else cost
// the short way past it, too. With a single axis it is called at one place, and shorter there.
#if SEVERAL_AXES
#define LARGE APART
#else
#define LARGE
#endif

static void begin_piece(struct axis *axis)
{
    BY_POINTER_SMALL(axis);
    const struct piece *piece = &axis->piece;

    if (piece->steps == 0) {
        feed_quiet(&axis->feed, piece->ticks);
        axis->phase = piece->has_edge ? DECODE_EDGE_BEHIND : DECODE_PIECE;
        return;
    }
    if (piece->has_edge && piece->edge_steps == 0) {
        feed_mark_here(&axis->feed, false, piece->edge_position);
    }
    walk_start(&axis->walk, piece);
    axis->phase = DECODE_STEPS;
}

APART_LARGE uint32_t decode_ahead_ticks(const struct axis *axis)
{
    uint32_t ahead = stream_end_ticks(&axis->feed.stream) - axis->ledger.loaded_ticks;

    if (axis->ledger.train != LEDGER_NO_TRAIN) {
        ahead -= (uint32_t)ledger_train_loaded(&axis->ledger) *
                 stream_train_base(&axis->feed.stream, axis->ledger.train);
    }
    return ahead;
}

// True when no piece may be begun for now: no waypoint is left, a seek is decoded far enough ahead,
// or a locked line waits for edges of the clock.
static bool no_more_pieces(const struct axis *axis)
{
    return stream_waypoints_full(&axis->feed.stream) || line_is_early(&axis->line) ||
           (segment_source_ends_early(&axis->line.source) &&
            decode_ahead_ticks(axis) > SEEK_AHEAD_TICKS);
}

// Begin the next piece. False when nothing can be decoded now.
static bool next_piece(struct axis *axis, const struct pixel_period *period)
{
    if (no_more_pieces(axis)) {
        return false;
    }
    axis->line.curve_half = 0;
    switch (line_next(&axis->line, &axis->piece)) {
    case LINE_PIECE:
        begin_piece(axis);
        return true;
    case LINE_OVER:
        axis_line_decoded(axis, period);
        return true;
    case LINE_DRY:
    default:
        axis->phase = DECODE_DRY;
        return false;
    }
}

// Steps that must still pass before the piece may become a pulse train. Intervals that only follow
// each other from train to train leave no room for them.
static uint8_t to_stagger(const struct axis *axis)
{
    uint8_t stagger = axis_stagger(axis);
    uint16_t taken = walk_taken(&axis->walk);

    if (taken >= stagger || axis->walk.steps.even.base_ticks < TRAIN_ENTRY_MIN_TICKS) {
        return 0;
    }
    return (uint8_t)(stagger - taken);
}

// True when the next steps can be handed over as a pulse train.
static bool train_due(const struct axis *axis)
{
    const struct even *even = &axis->walk.steps.even;
    uint16_t steps = walk_stretch(&axis->walk);

    return !axis->walk.curved && feed_steady(&axis->feed, axis->piece.negative) &&
           steps != 0 &&
           (steps >= TRAIN_MIN_STEPS || even->base_ticks < TRAIN_ENTRY_MIN_TICKS) &&
           to_stagger(axis) == 0 && stream_fits_train(&axis->feed.stream, even);
}

// True when there is time to wait for a train: now that one is due, and none is free.
static bool train_awaited(const struct axis *axis)
{
    const struct stream *stream = &axis->feed.stream;

    return axis->walk.steps.even.base_ticks < TRAIN_ENTRY_MIN_TICKS ||
           stream->newest_train_ticks >= TRAIN_WAIT_TICKS;
}

// Entries that must be free for decode_axis() to begin.
static inline uint8_t room_to_begin(const struct axis *axis)
{
    if (SEVERAL_AXES && axis->phase == DECODE_STEPS && axis->walk.curved) {
        return DECODE_ROOM;
    }
    return DECODE_ROOM_PIECE;
}

bool decode_is_ahead(const struct axis *axis)
{
    uint8_t phase = axis->phase;
    uint8_t space = stream_space(&axis->feed.stream);

    if (phase == DECODE_OUTSIDE || phase == DECODE_DRY || space < room_to_begin(axis) ||
        space < axis->line.room) {
        return true;
    }
    if (axis_awaits_train(axis)) {
        return !stream_train_free(&axis->feed.stream);
    }
    return phase == DECODE_PIECE && !feed_busy(&axis->feed) && no_more_pieces(axis);
}

// Go on behind a step: to its pixel edge, to more steps or to the next piece.
static APART void pass_step(struct axis *axis)
{
    bool over = walk_done(&axis->walk);

    if (axis->walk.at_edge) {
        axis->phase = over ? DECODE_EDGE_BEHIND : DECODE_EDGE_INSIDE;
    } else {
        axis->phase = over ? DECODE_PIECE : DECODE_STEPS;
    }
}

// Hand the next steps to the interrupt as a pulse train, as many as the ring has room for.
static void decode_train(struct axis *axis)
{
    uint8_t room = (uint8_t)(stream_space(&axis->feed.stream) - FEED_BURST);
    uint16_t fit = (uint16_t)((room + 1u) * STEP_TRAIN_ENTRY_MAX);
    uint16_t steps = walk_stretch(&axis->walk);

    if (steps > fit) {
        steps = fit;
    }
    walk_pass_train(
        &axis->walk, steps, feed_train(&axis->feed, &axis->walk.steps.even, steps));
    pass_step(axis);
}

// The most steps of a batch while the interrupt has so many entries to make, or a few less. With
// several axes they are known: a step is made while two or three are decoded.
static inline uint8_t batch_most(uint8_t ahead)
{
    if (SEVERAL_AXES) {
        ahead = ahead > INT8_MAX ? UINT8_MAX : (uint8_t)(2u * ahead);
    }
    return curve_batch_most(ahead);
}

// Decode up to `count` ordinary steps of a curve, as long as the fast decoders can make them. The
// steps become visible to the interrupt all at once.
static uint32_t burst_curve(struct axis *axis, uint8_t *count)
{
    struct stream *stream = &axis->feed.stream;
    uint8_t most = batch_most((uint8_t)(stream_used(stream) - axis_made_entries(axis)));
    struct curve_made made;

    curve_burst(&axis->walk.steps.curve,
                stream->ring,
                stream->head,
                *count < most ? *count : most,
                &made);
    *count = made.steps;
    if (made.steps == 0) {
        return 0;
    }
    stream_publish_batch(stream, made.steps, made.ticks, made.first_high);
    return made.ticks;
}

// The cost of one step is 2 to this power.
static uint8_t cost_shift(const struct axis *axis)
{
    return axis->walk.curved && axis->walk.steps.curve.kind == CURVE_FLAT_NOT
               ? STEEP_STEP_SHIFT
               : 0;
}

// The number of ordinary steps that budget, space in the ring and the walk allow.
static uint8_t burst_size(const struct axis *axis, uint8_t budget, uint8_t shift)
{
    uint8_t room = (uint8_t)(stream_space(&axis->feed.stream) - FEED_BURST);
    uint16_t steps = walk_burst(&axis->walk);
    uint8_t count = (uint8_t)(budget >> shift);

    if (count == 0) {
        count = 1;
    }
    // The slots of a batch are free when all of it is made. A single axis notes no batch.
    if (SEVERAL_AXES && count > CURVE_BATCH) {
        count = CURVE_BATCH;
    }
    if (room < count) {
        count = room;
    }
    if (steps < count) {
        count = (uint8_t)steps;
    }
    return count;
}

// True when the next step is an ordinary one, behind which nothing else is to be written.
static inline bool burst_due(const struct axis *axis)
{
    return walk_burst(&axis->walk) != 0 && feed_plain(&axis->feed, axis->piece.negative);
}

// Decode as many ordinary steps as possible; only when one is due. Returns what they cost of a
// round's budget, 0 if the fast decoders can make none.
static uint8_t decode_burst(struct axis *axis, uint8_t budget)
{
    uint8_t shift = cost_shift(axis);
    uint8_t count = burst_size(axis, budget, shift);
    uint32_t ticks = 0;

    if (axis->walk.curved) {
        ticks = burst_curve(axis, &count);
    } else if (axis->walk.steps.even.base_ticks < STEP_PERIOD_MAX_TICKS) {
        uint8_t stagger = to_stagger(axis);
        if (stagger != 0 && stagger < count) {
            count = stagger;
        }
        ticks = train_pixel_singles(&axis->walk.steps.even, &axis->feed.stream, count);
    } else {
        return 0;
    }
    walk_skip(&axis->walk, count, ticks);
    if (SEVERAL_AXES && !axis->walk.curved) {
        return SINGLES_COST(count);
    }
    return (uint8_t)(count << shift);
}

// Decode one step, special or ordinary. Returns what it cost of a round's budget: long intervals of
// a curve come from the slow path of its decoder.
static uint8_t decode_step(struct axis *axis)
{
    uint32_t ticks = walk_next(&axis->walk);

    feed_step(&axis->feed, ticks, axis->piece.negative);
    pass_step(axis);
    if (cost_shift(axis) != 0) {
        return SLOW_STEP_COST;
    }
    return axis->walk.curved ? CURVED_STEP_COST : 1u;
}

// Decode the next steps in the way that suits them. Returns what they cost of a round's budget, or
// 0 if they must wait.
static uint8_t decode_steps(struct axis *axis, uint8_t budget)
{
    axis->phase = DECODE_STEPS;
    if (train_due(axis)) {
        if (stream_train_free(&axis->feed.stream)) {
            decode_train(axis);
            return TRAIN_COST;
        }
        if (train_awaited(axis)) {
            axis->phase = DECODE_AWAITS_TRAIN;
            return 0;
        }
    }
    uint8_t cost = burst_due(axis) ? decode_burst(axis, budget) : 0;

    return cost != 0 ? cost : decode_step(axis);
}

static void mark_edge(struct axis *axis)
{
    feed_mark_here(&axis->feed, false, axis->piece.edge_position);
    axis->phase = axis->phase == DECODE_EDGE_INSIDE ? DECODE_STEPS : DECODE_PIECE;
    feed_make_room(&axis->feed, line_is_early(&axis->line));
}

// Decode the next pixel if it is a pulse train. Returns what it cost of a round's budget, 0 if it
// is another, or EVEN_PIXEL_WAITS.
static uint8_t decode_train_pixel(struct axis *axis)
{
    axis->phase = DECODE_PIECE;
    switch (train_pixel_write(&axis->line,
                              &axis->walk.steps.even,
                              &axis->feed.stream,
                              axis->feed.negative,
                              axis_stagger(axis))) {
    case TRAIN_PIXEL_DONE:
        return TRAIN_PIXEL_COST;
    case TRAIN_PIXEL_WAITS:
        axis->phase = DECODE_PIXEL_AWAITS_TRAIN;
        return EVEN_PIXEL_WAITS;
    case TRAIN_PIXEL_SINGLES:
        axis->phase = DECODE_PIXEL_SINGLES;
        axis->walk.until = (uint16_t)(axis->walk.steps.even.steps - 1u);
        return TRAIN_PIXEL_COST;
    case TRAIN_PIXEL_OTHER:
    default:
        return 0;
    }
}

// True when the ring has room for more.
static inline bool room_left(const struct stream *stream)
{
    return stream_space(stream) >= DECODE_ROOM_LEFT;
}

// How many of the steps that are left are written at once: the slots of a batch are free when all
// of it is made.
static inline uint8_t singles_batch(const struct stream *stream, const struct walk *walk)
{
    uint8_t count = (uint8_t)(stream_space(stream) - FEED_BURST);

    count = count < CURVE_BATCH ? count : (uint8_t)CURVE_BATCH;
    if (walk->until < count) {
        count = (uint8_t)walk->until;
    }
    return count;
}

// Write more of a pixel whose steps are entries, and the waypoint at its end. Returns what it cost
// of a round's budget.
static uint8_t decode_pixel_singles(struct axis *axis, uint8_t budget)
{
    struct stream *stream = &axis->feed.stream;
    struct walk *walk = &axis->walk;
    uint8_t left = budget;

    do {
        uint8_t count = singles_batch(stream, walk);

        (void)train_pixel_singles(&walk->steps.even, stream, count);
        walk->until = (uint16_t)(walk->until - count);
        if (walk->until == 0) {
            stream_add_waypoint(stream, false, (uint16_t)axis->line.position);
            axis->phase = DECODE_PIECE;
        }
        uint8_t cost = SINGLES_COST(count);
        left = left > cost ? (uint8_t)(left - cost) : 0;
    } while (left != 0 && walk->until != 0 && room_left(stream));
    return (uint8_t)(budget - left);
}

// Pixels other than the shortest even ones are written as a whole, too: they ask for the length.
#define LENGTH_ASKED (SEVERAL_AXES || FEATURE_SHORT_CURVES)

// True where a pixel of the clock begins, and nothing but the last step's period is still to be
// written in front of it.
static inline bool at_whole_pixel(const struct axis *axis)
{
    const struct feed *feed = &axis->feed;

    return axis->phase == DECODE_PIECE && feed_steady(feed, feed->negative) &&
           feed->pulse && stream_one_waypoint_waits(&feed->stream) &&
           line_on_pixels(&axis->line);
}

// Forget the room that an earlier pixel of the line waited for, so that no later one waits for as
// much.
static inline void forget_room(struct axis *axis)
{
    axis->line.room = 0;
}

// Decode a pixel that is under way in parts. Returns as decode_pixels().
static inline uint8_t decode_begun_pixel(struct axis *axis, uint8_t budget)
{
    if (SEVERAL_AXES && axis->phase == DECODE_PIXEL_AWAITS_TRAIN) {
        return decode_train_pixel(axis);
    }
    if (SEVERAL_AXES && axis->phase == DECODE_PIXEL_SINGLES) {
        return decode_pixel_singles(axis, budget);
    }
    return 0;
}

// Decode the next pixels if they have a way of their own. Returns what they cost of a round's
// budget, 0 if they are others, or EVEN_PIXEL_WAITS.
static uint8_t decode_pixels(struct axis *axis, uint8_t budget)
{
    if (!at_whole_pixel(axis)) {
        return decode_begun_pixel(axis, budget);
    }
    forget_room(axis);
    uint8_t cost =
        even_pixels_write(&axis->line, &axis->feed.stream, axis->feed.negative, budget);

    if (cost != 0 || !LENGTH_ASKED || line_is_early(&axis->line)) {
        return cost;
    }
    if (SEVERAL_AXES && line_many_steps(&axis->line, axis->feed.negative) != 0) {
        return decode_train_pixel(axis);
    }
    if (!FEATURE_SHORT_CURVES) {
        return 0;
    }
    return curved_pixel_write(
        &axis->line, &axis->walk.steps.curve.state.steep, &axis->feed.stream);
}

// Decode what comes next by way of pieces. Returns what it cost of a round's budget, 0 if it must
// wait.
static inline uint8_t decode_piece(struct axis *axis,
                                   const struct pixel_period *period,
                                   uint8_t budget)
{
    if (feed_busy(&axis->feed)) {
        feed_pump(&axis->feed);
        return PUMP_COST;
    }
    if (axis->phase >= DECODE_EDGE_INSIDE) {
        mark_edge(axis);
        return 1;
    }
    if (axis->phase >= DECODE_STEPS) {
        return decode_steps(axis, budget);
    }
    return next_piece(axis, period) ? PIECE_COST : 0;
}

// True inside a curve, where nothing but its next steps is to be written.
static inline bool in_curve(const struct axis *axis)
{
    return SEVERAL_AXES && axis->phase == DECODE_STEPS && axis->walk.curved &&
           !feed_busy(&axis->feed) && burst_due(axis);
}

// Decode more of a curve while it is narrow: most of a smooth line. Inside it nothing but its next
// steps is to be written. made: entries that the interrupt has made and that are not accounted for.
// Returns what is left of the budget.
static APART uint8_t decode_narrow(struct walk *walk,
                                   struct stream *stream,
                                   uint8_t made,
                                   uint8_t budget)
{
    BY_POINTER(walk);
    BY_POINTER(stream);
    while (budget != 0 && room_left(stream) && walk_burst(walk) != 0) {
        uint8_t used = stream_used(stream);
        uint8_t most = batch_most((uint8_t)(used - made));
        uint8_t room = (uint8_t)(STEP_RING_CAPACITY - FEED_BURST - used);
        uint16_t steps = walk_burst(walk);
        most = most < budget ? most : budget;
        most = most < room ? most : room;
        if (steps < most) {
            most = (uint8_t)steps;
        }
        uint8_t count = curve_narrow(&walk->steps.curve, most);
        if (count == 0) {
            break;
        }
        curve_batch_narrow(walk, stream, count);
        budget = (uint8_t)(budget - count);
    }
    return budget;
}

// Decode more of a curve. Returns what it cost of a round's budget, 0 if the fast decoders can make
// no step.
static inline uint8_t decode_curve(struct axis *axis, uint8_t budget)
{
    if (axis->walk.steps.curve.kind == CURVE_FLAT_NARROW) {
        uint8_t left = decode_narrow(
            &axis->walk, &axis->feed.stream, axis_made_entries(axis), budget);
        if (left != budget) {
            return (uint8_t)(budget - left);
        }
    }
    return decode_burst(axis, budget);
}

// True when the next pixel has no room now: the decoder need not ask for it again.
static inline bool next_pixel_waits(const struct axis *axis)
{
    const struct stream *stream = &axis->feed.stream;

    return SEVERAL_AXES && (axis->line.room > stream_space(stream) ||
                            (axis->phase == DECODE_PIECE &&
                             stream_waypoints_full(stream) && !feed_busy(&axis->feed)));
}

// Decode whatever comes next. Returns what is left of the budget.
static LARGE uint8_t decode_all(struct axis *axis,
                                const struct pixel_period *period,
                                uint8_t budget)
{
    while (budget != 0 && axis->phase != DECODE_OUTSIDE &&
           room_left(&axis->feed.stream)) {
        uint8_t cost =
            in_curve(axis) ? decode_curve(axis, budget) : decode_pixels(axis, budget);
        if (cost == EVEN_PIXEL_WAITS) {
            break;
        }
        if (cost == 0) {
            cost = decode_piece(axis, period, budget);
            if (cost == 0) {
                break;
            }
        }
        budget = budget > cost ? (uint8_t)(budget - cost) : 0;
        if (next_pixel_waits(axis)) {
            break;
        }
    }
    return budget;
}

#if SEVERAL_AXES
// Write the next pixels of a plain line: as decode_all() does, which saves many registers first.
// Returns true when nothing more can be decoded now; else decode_all() goes on.
static inline bool decode_plain(struct axis *axis, uint8_t *budget)
{
    struct stream *stream = &axis->feed.stream;

    if (axis->line.source.smooth || !room_left(stream) || !at_whole_pixel(axis)) {
        return false;
    }
    forget_room(axis);
    uint8_t cost = even_pixels_write(&axis->line, stream, axis->feed.negative, *budget);

    if (cost == EVEN_PIXEL_WAITS) {
        return true;
    }
    *budget = *budget > cost ? (uint8_t)(*budget - cost) : 0;
    return *budget == 0 || next_pixel_waits(axis);
}
#else
static inline bool decode_plain(struct axis *axis, uint8_t *budget)
{
    (void)axis;
    (void)budget;
    return false;
}
#endif

uint8_t decode_axis(struct axis *axis, const struct pixel_period *period, uint8_t budget)
{
    if (in_curve(axis)) {
        budget = decode_narrow(
            &axis->walk, &axis->feed.stream, axis_made_entries(axis), budget);
        if (budget == 0 || !room_left(&axis->feed.stream)) {
            return budget;
        }
    } else if (decode_plain(axis, &budget)) {
        return budget;
    }
    return decode_all(axis, period, budget);
}
