// SPDX-License-Identifier: MIT
#include "guarantee_pixel.h"

#include <math.h>

#define EVEN_STEPS       120u
#define EVEN_LEAST_TICKS 128.0
#define EVEN_MOST_TICKS  262143.0
#define CURVED_STEPS     64u
#define PIXEL_SLACK      0.0002 // a pixel may be off by so much,
// and longer where it follows a clock: that is as fast as declared.
#define LOCKED_SLACK 0.0022

void walk_begin(struct walk *walk, const struct guarantee_axis *line)
{
    *walk = (struct walk){
        .line = line,
        .shifted = line->backlash_steps != 0 && line->line_speed != 0,
        .count = INT32_MIN,
        .quiet = true,
    };
}

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

void walk_pass(struct walk *walk, const struct job *job)
{
    walk->done += job->part.steps;
    walk->waited = walk->steps > 0.0 ? 0.0 : job->part.end - job->front;
    if (job->last) {
        walk->begun = false;
    }
}
