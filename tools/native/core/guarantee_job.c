// SPDX-License-Identifier: MIT
#include "guarantee_pixel.h"

#include <math.h>

#define STEEP_BATCH  30.0 // of a board of several axes
#define SLOW_ENTRIES 48.0
#define MANY_STEPS   64.0
#define TRAIN_ENTRY  127.0
#define CRAWL        8.0  // times as fast at its other end
#define CRAWL_STEPS  20.0 // of so many, and of fewer less
#define PIECE_UNITS  60.0 // to begin one, of a board of several axes

// Periods of a long interval, but for its last.
static double chunks_of(double ticks)
{
    return ticks > PERIOD_TICKS ? ceil((ticks - PERIOD_TICKS) / CHUNK_TICKS) : 0.0;
}

static double when(const struct walk *w, double k)
{
    if (fabs(w->half) < 0.5) {
        return w->from + w->ticks * k / fmax(w->steps, 1.0);
    }
    double speed = sqrt(fmax(0.0, w->start_speed * w->start_speed + 4.0 * w->half * k));

    return w->from + w->ticks * (speed - w->start_speed) / (2.0 * w->half);
}

// Entries of pixels that the account does not take as a whole cost more.
static double entry_cost(const struct walk *w, const struct guarantee_costs *c)
{
    bool whole = (w->kind == EVEN || w->kind == CURVED) && w->ticks <= UINT16_MAX;

    return whole ? c->account_entry : c->account_long_entry;
}

static void cost_even(const struct walk *w,
                      const struct guarantee_costs *c,
                      struct job *job)
{
    job->part.entries = w->steps;
    job->cycles = c->even_px + c->even_step * w->steps +
                  (w->changed ? c->even_changed : 0.0) +
                  (w->begins ? c->even_begun : 0.0);
    job->units = 10.0 + w->steps / 4.0;
    job->part.account = c->account_px + entry_cost(w, c) * w->steps;
}

static void cost_train(const struct walk *w,
                       const struct guarantee_costs *c,
                       struct job *job)
{
    job->part.entries = 8.0 + ceil(w->steps / TRAIN_ENTRY);
    job->part.train = true;
    job->cycles = c->train_px + c->train_step * w->steps;
    job->units = 20.0;
}

// A board of several axes may spend a call on the beginning of a piece, and write it in another.
static void begin(const struct guarantee_board *board, double cycles, struct job *job)
{
    job->begin_cycles = cycles;
    job->begin_units = board->axes > 1 ? PIECE_UNITS : 0.0;
}

// To begin a piece that goes the common way.
static double piece_begun(const struct walk *w, const struct guarantee_costs *c)
{
    return c->piece_px + (w->shifted ? c->shifted_px : 0.0) +
           (w->turned ? c->turned_px : 0.0);
}

static void cost_singles(const struct walk *w,
                         const struct guarantee_costs *c,
                         const struct guarantee_board *board,
                         struct job *job)
{
    double steps = job->part.steps;

    job->part.entries = steps;
    job->cycles = c->single_step * steps;
    job->units = steps / 4.0;
    job->part.account = entry_cost(w, c) * steps;
    if (w->done > 0.0) {
        return;
    }
    if (w->common) {
        begin(board, piece_begun(w, c), job);
        job->cycles += c->piece_more;
        job->part.account += c->account_piece_px;
    } else {
        job->cycles += c->single_px;
        job->units += 20.0;
        job->part.account += c->account_px;
    }
}

static double cycles_of(const struct steps_found *n,
                        const struct guarantee_costs *c,
                        bool whole)
{
    double steep = whole ? c->curved_step : c->steep_step;

    return n->flat * c->flat_step + n->wide * c->wide_step + n->steep * steep +
           n->slow * c->slow_step + n->moved * c->moved_tick +
           n->wide_moved * c->wide_moved_tick + n->missed * c->missed_tick +
           n->batches * c->short_batch;
}

static struct curve_shape shape_of(const struct walk *w, bool whole)
{
    return (struct curve_shape){
        w->ticks, w->steps, w->start_speed, w->half, whole, whole && w->goes_on};
}

// More of a pixel that is slow at one end and fast at the other: there an interval tells little of
// the next one.
static double crawl(const struct walk *w, const struct guarantee_costs *c)
{
    double slow = fmin(w->start_speed, w->speed);
    double fast = fmax(w->start_speed, w->speed);

    double share = fmin(w->steps, CRAWL_STEPS) / CRAWL_STEPS;

    return slow * CRAWL <= fast ? share * c->crawl_px : 0.0;
}

// A pixel that is written as a whole: its last step is what is left of it.
static void cost_curved(const struct walk *w,
                        const struct guarantee_costs *c,
                        struct job *job)
{
    const struct curve_shape shape = shape_of(w, true);
    struct steps_found n = {0};

    guarantee_curve(&shape, 0.0, w->steps - 1.0, &n);
    job->part.entries = w->steps;
    job->cycles =
        c->curved_px + (w->goes_on ? 0.0 : c->curved_start) + cycles_of(&n, c, true);
    job->cycles += crawl(w, c);
    job->units = fmin(40.0 + 3.0 * w->steps + 20.0 * n.slow, 120.0);
    job->part.account = c->account_px + entry_cost(w, c) * w->steps;
}

// What these steps use up of a call's budget.
static double curve_units(const struct steps_found *n,
                          bool last,
                          bool steep,
                          bool several)
{
    double units = n->flat + n->wide;

    if (several) {
        units += 4.0 * n->steep + 36.0 * n->slow;
    } else {
        units += 2.0 * n->steep + 24.0 * n->slow;
    }
    if (last) { // a step on its own
        double extra = several ? 14.0 : 12.0;
        units += (several ? 22.0 : 12.0) + (steep ? extra : 0.0);
    }
    return units;
}

static void cost_curve(const struct walk *w,
                       const struct guarantee_costs *c,
                       const struct guarantee_board *board,
                       struct job *job)
{
    const struct curve_shape shape = shape_of(w, false);
    struct steps_found n = {0};
    double steps = job->part.steps;
    bool first = w->done <= 0.0;
    bool steep = guarantee_curve_steep(&shape, fmax(0.0, w->done + steps - 1.0));

    guarantee_curve(&shape, w->done, w->done + steps, &n);
    job->part.entries = steps;
    job->cycles = cycles_of(&n, c, false);
    if (first) {
        begin(board, c->curve_px + (w->shifted ? c->shifted_px : 0.0), job);
        job->cycles += crawl(w, c);
    }
    job->units = curve_units(&n, job->last, steep, board->axes > 1);
    job->part.account = (first ? c->account_curve_px : 0.0) + entry_cost(w, c) * steps;
}

// Entries of steps between which the counter wraps: as the wraps pass, each some 4 ms, there is
// room for more, and the decoder writes a few at a time.
static double slow_entries(double steps, double waits)
{
    return waits > 0.0 ? fmin(steps + waits, SLOW_ENTRIES) : steps;
}

static void cost_piece(const struct walk *w,
                       const struct guarantee_costs *c,
                       const struct guarantee_board *board,
                       struct job *job)
{
    double interval = w->ticks / fmax(w->steps, 1.0);
    double waits =
        chunks_of(w->waited + interval) + chunks_of(interval) * fmax(w->steps - 1.0, 0.0);
    bool train = w->steps > TRAIN_STEPS;

    job->part.entries =
        train ? 8.0 + ceil(w->steps / TRAIN_ENTRY) : slow_entries(w->steps, waits);
    job->part.train = train;
    begin(board, piece_begun(w, c), job);
    job->cycles = c->pump * waits + (w->steps > 1.5 ? c->piece_more : 0.0);
    job->cycles += (train ? c->train_step : c->piece_step) * w->steps;
    job->units = 2.0 + (train ? 20.0 : w->steps) + 6.0 * waits;
    job->part.account = c->account_piece_px + entry_cost(w, c) * job->part.entries;
}

static void cost_zero(const struct walk *w,
                      const struct guarantee_costs *c,
                      const struct guarantee_board *board,
                      struct job *job)
{
    double waits = chunks_of(w->waited + w->ticks);

    begin(board, c->zero_px, job);
    job->part.entries = slow_entries(0.0, 1.0 + waits);
    job->cycles = c->pump * waits;
    job->units = 1.0 + 6.0 * fmax(waits - 1.0, 0.0); // the first comes with the piece
    job->part.account = c->account_piece_px + entry_cost(w, c) * (1.0 + waits);
}

static void cost_part(const struct walk *w,
                      const struct guarantee_costs *c,
                      const struct guarantee_board *board,
                      struct job *job)
{
    switch (w->kind) {
    case EVEN:
        cost_even(w, c, job);
        break;
    case TRAIN:
        cost_train(w, c, job);
        break;
    case SINGLES:
        cost_singles(w, c, board, job);
        break;
    case CURVED:
        cost_curved(w, c, job);
        break;
    case CURVE:
        cost_curve(w, c, board, job);
        break;
    case PIECE:
        cost_piece(w, c, board, job);
        break;
    case ZERO:
    default:
        cost_zero(w, c, board, job);
        break;
    }
}

// How many steps are written at once. A piece of a curve goes in batches, and so do steps that no
// train can make.
static double batch(const struct walk *w,
                    const struct guarantee_board *board,
                    double most)
{
    double left = w->steps - w->done;

    if (w->kind == SINGLES) {
        return fmin(left, most);
    }
    if (w->kind != CURVE) {
        return left;
    }
    const struct curve_shape shape = shape_of(w, false);
    bool steep = board->axes > 1 && guarantee_curve_steep(&shape, w->done);

    return fmin(left, steep ? fmin(most, STEEP_BATCH) : most);
}

// Of a wait without a step only chunks are written; what is left goes into the step that follows.
static void find_front(const struct walk *w, struct job *job)
{
    double done = w->done + job->part.steps;
    double waited = done < 2.0 ? w->waited : 0.0;

    job->front = job->part.end;
    if (job->part.steps > 0.0) {
        double interval = waited + job->part.end - when(w, done - 1.0);
        job->last_ticks = interval - chunks_of(interval) * CHUNK_TICKS;
        return;
    }
    double chunks = chunks_of(waited + w->ticks);
    job->front += chunks * CHUNK_TICKS - waited - w->ticks;
    job->last_ticks = CHUNK_TICKS;
    job->waits = chunks <= 0.0;
}

// Whether passes beside it cost more: looks at the account of many steps find nothing until their
// pixel is over.
static bool is_other(const struct walk *w, double steps)
{
    switch (w->kind) {
    case EVEN:
    case CURVED:
        return steps > MANY_STEPS;
    case SINGLES:
        return w->common;
    case CURVE:
        return false;
    case TRAIN:
    case PIECE:
    case ZERO:
    default:
        return true;
    }
}

void walk_job(const struct walk *walk,
              const struct guarantee_costs *costs,
              const struct guarantee_board *board,
              double most,
              struct job *job)
{
    double steps = batch(walk, board, most);

    *job = (struct job){0};
    job->part.steps = steps;
    job->part.begin = when(walk, walk->done);
    job->last = walk->done + steps >= walk->steps;
    job->part.end = job->last ? walk->from + walk->ticks : when(walk, walk->done + steps);
    job->part.mark = job->last;
    job->part.whole = walk->kind == EVEN || walk->kind == CURVED;
    job->part.other = is_other(walk, steps);
    cost_part(walk, costs, board, job);
    if (board->lead_edges != 0 && walk->done <= 0.0) {
        job->cycles += costs->locked_px;
    }
    find_front(walk, job);
}
