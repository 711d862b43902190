// SPDX-License-Identifier: MIT
#include "guarantee_pixel.h"

#include <math.h>

#define STEEP_BATCH      30.0 // of a board of several axes
#define EVEN_STEPS       120u
#define EVEN_LEAST_TICKS 128.0
#define EVEN_MOST_TICKS  262143.0
#define CURVED_STEPS     64u
#define SLOW_ENTRIES     48.0
#define TRAIN_ENTRY      127.0
#define CRAWL            8.0  // times as fast at its other end
#define CRAWL_STEPS      8.0  // one of fewer is dear for that alone
#define PIECE_UNITS      60.0 // to begin one, of a board of several axes
#define TRAIN_STEPS      16.0 // more are handed over as a train, where one can make them
#define PIXEL_SLACK      0.0002 // a pixel may be off by so much,
#define LOCKED_SLACK                                                                     \
    0.0022 // and longer where it follows a clock: that is as fast as declared

void walk_begin(struct walk *walk, const struct guarantee_axis *line)
{
    *walk = (struct walk){
        .line = line,
        .shifted = line->backlash_steps != 0 && line->line_speed != 0,
        .count = INT32_MIN,
        .quiet = true,
    };
}

// ---- pieces ----

static double ahead(const struct walk *w, const struct guarantee_board *board)
{
    return w->shifted ? board->pixel_ticks * w->line->backlash_steps / w->line->line_speed
                      : 0.0;
}

// A train's two intervals must have one high byte: whole periods of 256 k ticks do not.
static bool no_train(const struct guarantee_board *board, double ticks, double steps)
{
    double least = ticks / steps * (1.0 - PIXEL_SLACK);
    double most =
        ticks / steps * (1.0 + (board->lead_edges != 0 ? LOCKED_SLACK : PIXEL_SLACK));

    return floor(least / 256.0) < floor(most / 256.0) ||
           least - 256.0 * floor(least / 256.0) < 1.0;
}

static enum kind common_kind(const struct guarantee_board *board,
                             double ticks,
                             double steps)
{
    return steps > TRAIN_STEPS && no_train(board, ticks, steps) ? SINGLES : PIECE;
}

static enum kind kind_of_even(const struct walk *w,
                              const struct guarantee_board *board,
                              double ticks,
                              double steps)
{
    bool even = steps <= EVEN_STEPS && ticks / steps >= EVEN_LEAST_TICKS &&
                ticks <= EVEN_MOST_TICKS && ticks / steps <= PERIOD_TICKS;

    if (w->turned || w->shifted || w->quiet) {
        return common_kind(board, ticks, steps);
    }
    if (even) {
        return EVEN;
    }
    if (steps > EVEN_STEPS) {
        return no_train(board, ticks, steps) ? SINGLES : TRAIN;
    }
    return common_kind(board, ticks, steps);
}

static enum kind kind_of_curve(const struct walk *w,
                               const struct guarantee_board *board,
                               double ticks,
                               double steps,
                               double end)
{
    double slowest = fmin(w->speed, end);
    double fastest = fmax(w->speed, end);
    bool fits = (ticks <= 0xFC00 || slowest > ticks / 32768.0) &&
                ticks / EVEN_LEAST_TICKS >= fastest;

    return board->short_curves && !w->turned && !w->shifted && !w->quiet &&
                   steps <= CURVED_STEPS && fits
               ? CURVED
               : CURVE;
}

// Behind a change of direction, or the last part of a long interval, no pulse is due before the
// step that follows: another step of the same piece brings one.
static bool ends_quiet(const struct walk *w, double ticks, double steps)
{
    double interval = steps < 2.0 ? w->waited + ticks : ticks / steps;

    return steps <= 0.0 || interval > PERIOD_TICKS || (w->turned && steps < 2.0);
}

static void set_piece(struct walk *w, enum kind kind, double ticks, double steps)
{
    w->kind = kind;
    w->quiet = ends_quiet(w, ticks, steps);
    w->from = w->from + w->ticks;
    w->ticks = ticks;
    w->steps = steps;
    w->done = 0.0;
    w->half = 0.0;
    w->begun = true;
    w->changed = false;
    w->begins = false;
    w->goes_on = false;
    w->common = false;
}

// The backlash, at line speed, up to the pixel's edge.
static void take_up(struct walk *w, const struct guarantee_board *board)
{
    double ticks = ahead(w, board);

    w->shifted = false;
    w->going = 0.0;
    set_piece(w,
              common_kind(board, ticks, w->line->backlash_steps),
              ticks,
              w->line->backlash_steps);
    w->common = true;
}

static void take_curve(struct walk *w, const struct guarantee_board *board, double steps)
{
    double end = 2.0 * steps - w->speed;
    double half = steps - w->speed;
    enum kind kind = kind_of_curve(w, board, board->pixel_ticks, steps, end);

    set_piece(w, kind, board->pixel_ticks, steps);
    w->goes_on = kind == CURVED && fabs(half - w->going) < 0.5;
    w->half = half;
    w->start_speed = w->speed;
    w->speed = end;
}

static void take_even(struct walk *w,
                      const struct guarantee_board *board,
                      int32_t count,
                      double steps)
{
    double ticks = board->pixel_ticks;
    bool changed = count != w->count;
    bool begins = w->kind != EVEN;
    bool common = w->turned || w->shifted || w->quiet || steps <= EVEN_STEPS;

    set_piece(w, kind_of_even(w, board, ticks, steps), ticks, steps);
    w->common = common;
    w->changed = changed && !begins;
    w->begins = begins;
    w->speed = steps;
}

static void take_pixel(struct walk *w, const struct guarantee_board *board)
{
    const struct segment *run = &w->line->entries[w->entry];
    double steps = fabs((double)run->count);
    double ticks = board->pixel_ticks;
    bool leading = w->shifted && w->pixel == 0;

    if (++w->repeat >= run->repeat) {
        w->entry++;
        w->repeat = 0;
    }
    w->pixel++;
    if (leading) {
        set_piece(w, ZERO, ticks - ahead(w, board), 0.0);
        return;
    }
    w->turned = run->count != 0 && (run->count < 0) != w->negative;
    if (run->count != 0) {
        w->negative = run->count < 0;
    }
    if (steps <= 0.0) {
        set_piece(w, ZERO, ticks, 0.0);
    } else if (w->line->smooth && fabs(steps - w->speed) > 0.5) {
        take_curve(w, board, steps);
    } else {
        take_even(w, board, run->count, steps);
    }
    w->going = w->kind == CURVED ? w->half : 0.0;
    w->count = run->count;
}

bool walk_piece(struct walk *walk, const struct guarantee_board *board)
{
    if (walk->begun) {
        return true;
    }
    if (walk->shifted && walk->pixel > 0 &&
        fabs(walk->speed - walk->line->line_speed) < 0.5) {
        take_up(walk, board);
        return true;
    }
    if (walk->over || walk->entry >= walk->line->count) {
        walk->over = true;
        return false;
    }
    take_pixel(walk, board);
    return true;
}

// ---- what is written at once ----

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

static double pumps(double ticks)
{
    return ticks > PERIOD_TICKS ? ceil(ticks / PERIOD_TICKS) : 0.0;
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
    job->part.account = c->account_train_px;
}

// To begin a piece that goes the common way.
static double piece_begun(const struct walk *w, const struct guarantee_costs *c)
{
    return c->piece_px + (w->shifted ? c->shifted_px : 0.0) +
           (w->turned ? c->turned_px : 0.0) + (w->steps > 1.5 ? c->piece_more : 0.0);
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
        job->cycles += piece_begun(w, c);
        job->units += board->axes > 1 ? PIECE_UNITS : 0.0;
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

    return w->steps > CRAWL_STEPS && slow * CRAWL <= fast ? c->crawl_px : 0.0;
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
static double curve_units(
    const struct steps_found *n, bool first, bool last, bool steep, bool several)
{
    double units = n->flat + n->wide;

    if (several) {
        units += (first ? 60.0 : 0.0) + 4.0 * n->steep + 36.0 * n->slow;
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
        job->cycles += c->curve_px + crawl(w, c) + (w->shifted ? c->shifted_px : 0.0);
    }
    job->units = curve_units(&n, first, job->last, steep, board->axes > 1);
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
    double waits = pumps(w->ticks / fmax(w->steps, 1.0)) * fmax(w->steps, 1.0);
    bool train = w->steps > TRAIN_STEPS;

    job->part.entries =
        train ? 8.0 + ceil(w->steps / TRAIN_ENTRY) : slow_entries(w->steps, waits);
    job->part.train = train;
    job->cycles = piece_begun(w, c) + c->pump * waits;
    job->cycles += (train ? c->train_step : c->piece_step) * w->steps;
    job->units = board->axes > 1 ? PIECE_UNITS : 0.0;
    job->units += 2.0 + (train ? 20.0 : w->steps) + 6.0 * waits;
    job->part.account = c->account_piece_px + entry_cost(w, c) * job->part.entries;
    if (train) {
        job->part.account += c->account_train_px;
    }
}

static void cost_zero(const struct walk *w,
                      const struct guarantee_costs *c,
                      const struct guarantee_board *board,
                      struct job *job)
{
    double waits = 1.0 + pumps(w->ticks);

    job->part.entries = slow_entries(0.0, waits);
    job->cycles = c->zero_px + c->pump * waits;
    job->units = (board->axes > 1 ? PIECE_UNITS : 0.0) + 2.0 + 6.0 * waits;
    job->part.account = c->account_piece_px + entry_cost(w, c) * waits;
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

// Long intervals are cut into chunks, but for the last period.
static double in_chunks(double ticks)
{
    return ticks > PERIOD_TICKS ? CHUNK_TICKS * ceil((ticks - PERIOD_TICKS) / CHUNK_TICKS)
                                : 0.0;
}

// Of a wait without a step only chunks are written; what is left goes into the step that follows.
static void find_front(const struct walk *w, struct job *job)
{
    double done = w->done + job->part.steps;
    double waited = done < 2.0 ? w->waited : 0.0;

    job->front = job->part.end;
    if (job->part.steps > 0.0) {
        double interval = waited + job->part.end - when(w, done - 1.0);
        job->last_ticks = interval - in_chunks(interval);
        return;
    }
    double chunks = in_chunks(waited + w->ticks);
    job->front += chunks - waited - w->ticks;
    job->last_ticks = CHUNK_TICKS;
    job->waits = chunks <= 0.0;
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
    job->part.other = walk->kind == PIECE || walk->kind == ZERO || walk->kind == TRAIN ||
                      (walk->kind == SINGLES && walk->common);
    cost_part(walk, costs, board, job);
    if (board->lead_edges != 0 && walk->done <= 0.0) {
        job->cycles += costs->locked_px;
    }
    find_front(walk, job);
}

void walk_pass(struct walk *walk, const struct job *job)
{
    walk->done += job->part.steps;
    walk->waited = walk->steps > 0.0 ? 0.0 : job->part.end - job->front;
    if (job->last) {
        walk->begun = false;
    }
}
