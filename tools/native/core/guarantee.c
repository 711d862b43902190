// SPDX-License-Identifier: MIT
#include "guarantee.h"

#include <math.h>
#include <stdlib.h>

#define RING_ENTRIES     244.0 // of 252, less what a step may take
#define ROOM_TO_BEGIN    64.0
#define ROOM_IN_CURVE    40.0
#define MARKS            15u
#define TRAINS           2u
#define BATCH            60.0
#define EVEN_STEPS       120u
#define EVEN_LEAST_TICKS 128.0
#define EVEN_MOST_TICKS  262143.0
#define CURVED_STEPS     64u
#define TRAIN_ENTRY      127.0
#define PERIOD_TICKS     64768.0 // longest period of the timer
#define PARTS            256u    // a ring has no more
// Budgets of the firmware's rounds (round.c, decode.c), in units of a step of a flat curve.
#define CALL_UNITS    120.0
#define MISS_TICKS    16.0
#define QUICK_TICKS   32767.0
#define PIXEL_SLACK   0.0002 // a clock may be off by so much
#define WIDE_LIMIT    7e8
#define WIDE_SPEED    2800.0
#define WAITING_LEADS 4u
#define NEVER_TICKS   1e300
#define FIRST_STEPS   3.0

enum kind { EVEN, TRAIN, SINGLES, CURVED, PIECE, CURVE, ZERO };

struct part {
    double begin, end; // ticks from line zero
    double entries, steps, account;
    bool mark, train;
};

// What the decoder writes at once.
struct job {
    struct part part;
    double cycles, units;
    bool last; // of its piece
    double interval;
};

struct axis {
    const struct guarantee_axis *line;
    uint32_t entry, repeat; // runs that are used up, pixels of the present one that are
    uint32_t pixel;         // pixels that are taken
    bool over, shifted, turned;
    bool rested;   // the piece before has no step: what follows takes the common way
    double speed;  // at the place, steps a pixel
    int32_t count; // of the pixel before
    bool negative;
    // The piece in work.
    enum kind kind;
    bool begun, first;
    double from, ticks, steps, done, half, start_speed, even_changed;
    // What is written and not accounted for.
    struct part parts[PARTS];
    uint8_t head, tail, plays; // written, accounted for, being made
    double used;
    uint32_t marks, trains;
    double end, interval; // of what is written
    bool known;           // the part that is to be written next
    struct job next;
};

struct replay {
    const struct guarantee_costs *cost;
    const struct guarantee_board *board;
    struct guarantee_verdict *verdict;
    struct axis axis[GUARANTEE_AXES];
    uint32_t axes;
    double now;        // ticks from line zero
    double work;       // cycles of the main loop so far
    double edges;      // of the clock that were taken
    double edge_ticks; // between two
    uint8_t rounds;
    bool several;
    bool started; // line zero has come: what is written from then on takes time
};

// ---- curves ----

static double steps_until(double speed, double from, double half)
{
    return (speed * speed - from * from) / (4.0 * half);
}

// Steps of k0..k1 that are slower than `limit`.
static double slower(double limit, double from, double half, double k0, double k1)
{
    double k = steps_until(limit, from, half);

    if (half > 0.0) {
        return fmax(0.0, fmin(k, k1) - k0);
    }
    return fmax(0.0, k1 - fmax(k, k0));
}

// The first steps of a piece are found by Newton's method where its speed does not foretell them.
static bool foretold(double ticks, double speed, double h)
{
    double interval = ticks / fmax(speed, 1.0);
    double change = interval * h / fmax(speed * speed, 1.0);

    return speed > ticks / 65536.0 && interval <= QUICK_TICKS - 255.0 &&
           change <= 255.0 && change * change <= interval;
}

// Where flat steps count: the usual ones, those of 40 bits, those of much acceleration.
static int flat_kind(double ticks, double speed, double half, double total)
{
    double last = sqrt(fmax(0.0, speed * speed + 4.0 * half * total));
    double top = fmax(speed, last);
    double low = fmin(speed, last);
    bool loose = 2.0 * fabs(half) * ticks >= low * low * low;
    double share = loose ? 0.5 : 1.0;

    if (top * ticks > WIDE_LIMIT * share || top > WIDE_SPEED * share) {
        return 1;
    }
    return loose ? 4 : 0;
}

void guarantee_curve(double ticks,
                     double speed,
                     double half,
                     double total,
                     double k0,
                     double k1,
                     bool steep,
                     double *counts)
{
    double h = fabs(half);
    double slow_speed =
        fmax(pow(12.0 / MISS_TICKS * h * h * ticks, 0.2), ticks / QUICK_TICKS);
    double steep_speed = cbrt(h * ticks);
    double slow = slower(slow_speed, speed, half, k0, k1);
    if (k0 <= 0.0 && !foretold(ticks, speed, h)) {
        slow = fmax(slow, fmin(k1, FIRST_STEPS));
    }
    double bent = steep ? k1 - k0 : slower(steep_speed, speed, half, k0, k1);

    bent = fmax(0.0, fmin(bent, k1 - k0) - slow);
    double flat = k1 - k0 - slow - bent;

    counts[flat_kind(ticks, speed, half, total)] += flat;
    counts[2] += bent;
    counts[3] += slow;
}

// ---- pieces ----

static double period(const struct replay *r)
{
    return r->board->pixel_ticks;
}

static double ahead(const struct replay *r, const struct axis *a)
{
    return a->shifted ? period(r) * a->line->backlash_steps / a->line->line_speed : 0.0;
}

// A train's two intervals must have one high byte: whole periods of 256 k ticks do not.
static bool no_train(double ticks, double steps)
{
    double least = ticks / steps * (1.0 - PIXEL_SLACK);
    double most = ticks / steps * (1.0 + PIXEL_SLACK);

    return floor(least / 256.0) < floor(most / 256.0) ||
           least - 256.0 * floor(least / 256.0) < 1.0;
}

static enum kind kind_of_even(const struct axis *a, double ticks, double steps)
{
    bool even = steps <= EVEN_STEPS && ticks / steps >= EVEN_LEAST_TICKS &&
                ticks <= EVEN_MOST_TICKS && ticks / steps <= PERIOD_TICKS;

    if (a->turned || a->shifted || a->rested) {
        return PIECE;
    }
    if (even) {
        return EVEN;
    }
    if (steps > EVEN_STEPS) {
        return no_train(ticks, steps) ? SINGLES : TRAIN;
    }
    return PIECE;
}

static enum kind kind_of_curve(
    const struct replay *r, const struct axis *a, double ticks, double steps, double end)
{
    double slowest = fmin(a->speed, end);
    double fastest = fmax(a->speed, end);
    bool fits = (ticks <= 0xFC00 || slowest > ticks / 32768.0) &&
                ticks / EVEN_LEAST_TICKS >= fastest;

    return r->board->short_curves && !a->shifted && steps <= CURVED_STEPS && fits ? CURVED
                                                                                  : CURVE;
}

static void set_piece(struct axis *a, enum kind kind, double ticks, double steps)
{
    a->kind = kind;
    a->rested = steps <= 0.0;
    a->from = a->from + a->ticks;
    a->ticks = ticks;
    a->steps = steps;
    a->done = 0.0;
    a->half = 0.0;
    a->begun = true;
    a->even_changed = 0.0;
}

// The backlash, at line speed, up to the pixel's edge.
static void take_up(struct replay *r, struct axis *a)
{
    double ticks = ahead(r, a);

    a->shifted = false;
    set_piece(a, PIECE, ticks, a->line->backlash_steps);
}

static void take_pixel(struct replay *r, struct axis *a)
{
    const struct segment *run = &a->line->entries[a->entry];
    double steps = fabs((double)run->count);
    double ticks = period(r);
    bool leading = a->shifted && a->pixel == 0;

    if (++a->repeat >= run->repeat) {
        a->entry++;
        a->repeat = 0;
    }
    a->pixel++;
    if (leading) {
        set_piece(a, ZERO, ticks - ahead(r, a), 0.0);
        return;
    }
    a->turned = run->count != 0 && (run->count < 0) != a->negative;
    if (run->count != 0) {
        a->negative = run->count < 0;
    }
    if (steps <= 0.0) {
        set_piece(a, ZERO, ticks, 0.0);
    } else if (a->line->smooth && fabs(steps - a->speed) > 0.5) {
        double end = 2.0 * steps - a->speed;
        double speed = a->speed;
        enum kind kind = kind_of_curve(r, a, ticks, steps, end);
        set_piece(a, kind, ticks, steps);
        a->half = steps - speed;
        a->start_speed = speed;
        a->speed = end;
    } else {
        set_piece(a, kind_of_even(a, ticks, steps), ticks, steps);
        a->even_changed = run->count != a->count ? 1.0 : 0.0;
        a->speed = steps;
    }
    a->count = run->count;
}

static bool have_piece(struct replay *r, struct axis *a)
{
    if (a->begun) {
        return true;
    }
    if (a->shifted && a->pixel > 0 && fabs(a->speed - a->line->line_speed) < 0.5) {
        take_up(r, a);
        return true;
    }
    if (a->over || a->entry >= a->line->count) {
        a->over = true;
        return false;
    }
    take_pixel(r, a);
    return true;
}

// ---- what is written at once ----

static double when(const struct axis *a, double k)
{
    if (fabs(a->half) < 0.5) {
        return a->from + a->ticks * k / fmax(a->steps, 1.0);
    }
    double speed = sqrt(fmax(0.0, a->start_speed * a->start_speed + 4.0 * a->half * k));

    return a->from + a->ticks * (speed - a->start_speed) / (2.0 * a->half);
}

// Entries of pixels that the account does not take as a whole cost more.
static double entry_cost(const struct replay *r, const struct axis *a)
{
    bool whole = (a->kind == EVEN || a->kind == CURVED) && a->ticks <= UINT16_MAX;

    return whole ? r->cost->account_entry : r->cost->account_long_entry;
}

static double pumps(double ticks)
{
    return ticks > PERIOD_TICKS ? ceil(ticks / PERIOD_TICKS) : 0.0;
}

static void cost_even(const struct replay *r, const struct axis *a, struct job *job)
{
    const struct guarantee_costs *c = r->cost;

    job->part.entries = a->steps;
    job->cycles =
        c->even_px + c->even_step * a->steps + c->even_changed * a->even_changed;
    job->units = 8.0 + a->steps / 4.0;
    job->part.account = c->account_px + entry_cost(r, a) * a->steps;
}

static void cost_train(const struct replay *r, const struct axis *a, struct job *job)
{
    const struct guarantee_costs *c = r->cost;

    job->part.entries = 8.0 + ceil(a->steps / TRAIN_ENTRY);
    job->part.train = true;
    job->cycles = c->train_px + c->train_step * a->steps;
    job->units = 20.0;
    job->part.account = c->account_train_px + c->account_train_step * a->steps;
}

static void cost_part_of_singles(const struct replay *r,
                                 const struct axis *a,
                                 struct job *job)
{
    const struct guarantee_costs *c = r->cost;
    double steps = job->part.steps;

    job->part.entries = steps;
    job->cycles = (a->done <= 0.0 ? c->single_px : 0.0) + c->single_step * steps;
    job->units = (a->done <= 0.0 ? 20.0 : 0.0) + steps / 4.0;
    job->part.account = (a->done <= 0.0 ? c->account_px : 0.0) + entry_cost(r, a) * steps;
}

static void cost_curve(const struct replay *r, const struct axis *a, struct job *job)
{
    const struct guarantee_costs *c = r->cost;
    double n[5] = {0.0};
    double steps = job->part.steps;
    bool first = a->done <= 0.0;
    double pixel = a->kind == CURVED ? c->curved_px
                                     : c->curve_px + (a->shifted ? c->shifted_px : 0.0);

    guarantee_curve(a->ticks,
                    a->start_speed,
                    a->half,
                    a->steps,
                    a->done,
                    a->done + steps,
                    a->kind == CURVED,
                    n);
    job->part.entries = steps;
    job->cycles = (first ? pixel : 0.0) + n[0] * c->flat_step + n[1] * c->wide_step +
                  n[2] * c->steep_step + n[3] * c->slow_step + n[4] * c->loose_step;
    job->units = (first ? 60.0 : 0.0) + n[0] + n[1] + n[4] + 4.0 * n[2] + 36.0 * n[3];
    if (a->kind == CURVED) {
        job->units = 40.0 + 3.0 * steps;
    }
    job->part.account = (first ? c->account_px : 0.0) + entry_cost(r, a) * steps;
}

static void cost_piece(const struct replay *r, const struct axis *a, struct job *job)
{
    const struct guarantee_costs *c = r->cost;
    double waits = pumps(a->ticks / fmax(a->steps, 1.0)) * fmax(a->steps, 1.0);
    double train = a->steps > 16.0 ? 1.0 : 0.0;

    job->part.entries =
        train > 0.0 ? 8.0 + ceil(a->steps / TRAIN_ENTRY) : a->steps + waits;
    job->part.train = train > 0.0;
    job->cycles = c->piece_px + (a->shifted ? c->shifted_px : 0.0) +
                  (a->turned ? c->turned_px : 0.0) + c->pump * waits;
    job->cycles += train > 0.0 ? c->train_step * a->steps : c->piece_step * a->steps;
    job->units = 42.0 + 6.0 * waits;
    job->part.account = c->account_piece_px + entry_cost(r, a) * job->part.entries;
    if (train > 0.0) {
        job->part.account += c->account_train_px + c->account_train_step * a->steps;
    }
}

static void cost_zero(const struct replay *r, const struct axis *a, struct job *job)
{
    const struct guarantee_costs *c = r->cost;
    double waits = 1.0 + pumps(a->ticks);

    job->part.entries = waits;
    job->cycles = c->zero_px + c->pump * waits;
    job->units = 30.0 + 6.0 * waits;
    job->part.account = c->account_piece_px + entry_cost(r, a) * waits;
}

// A piece of a curve goes in batches; a long one of single steps too.
static bool in_batches(const struct axis *a)
{
    return a->kind == SINGLES || a->kind == CURVE;
}

static void cost_part(const struct replay *r, const struct axis *a, struct job *job)
{
    switch (a->kind) {
    case EVEN:
        cost_even(r, a, job);
        break;
    case TRAIN:
        cost_train(r, a, job);
        break;
    case SINGLES:
        cost_part_of_singles(r, a, job);
        break;
    case CURVED:
    case CURVE:
        cost_curve(r, a, job);
        break;
    case PIECE:
        cost_piece(r, a, job);
        break;
    case ZERO:
    default:
        cost_zero(r, a, job);
        break;
    }
}

static void next_job(const struct replay *r, const struct axis *a, struct job *job)
{
    *job = (struct job){0};
    double left = a->steps - a->done;
    double steps = in_batches(a) ? fmin(left, BATCH) : left;

    job->part.steps = steps;
    job->part.begin = when(a, a->done);
    job->last = a->done + steps >= a->steps;
    job->part.end = job->last ? a->from + a->ticks : when(a, a->done + steps);
    job->part.mark = job->last;
    cost_part(r, a, job);
    if (r->board->lead_edges != 0 && a->done <= 0.0) {
        job->cycles += r->cost->locked_px;
    }
    job->interval = steps > 0.0 ? job->part.end - when(a, a->done + steps - 1.0)
                                : fmin(a->ticks, PERIOD_TICKS);
    job->interval = fmin(job->interval, PERIOD_TICKS);
}

static bool has_room(const struct axis *a, const struct job *job)
{
    double room = RING_ENTRIES + 8.0 - a->used;
    double least = a->kind == CURVE && a->done > 0.0 ? ROOM_IN_CURVE : ROOM_TO_BEGIN;

    if (a->kind == CURVE || a->kind == SINGLES) {
        return room >= least;
    }
    return room >= fmin(fmax(least, job->part.entries), RING_ENTRIES);
}

static bool is_early(const struct replay *r, const struct axis *a)
{
    const struct guarantee_board *b = r->board;
    double lead = b->lead_edges;

    if (b->lead_edges == 0 || a->done > 0.0) {
        return false;
    }
    if (!r->started && r->several) {
        lead = (lead - 1.0) * WAITING_LEADS + 1.0;
    } else if (r->several) {
        lead += b->more_edges;
    }
    // The pixel begins at edge a->pixel - 1, counted from line zero; before that none has come.
    double begins = (double)a->pixel - (a->shifted ? 2.0 : 1.0);

    return begins * b->divider - (r->edges - 1.0) > lead;
}

// True when the next part of an axis, a->next, may be written now.
static bool may_write(struct replay *r, struct axis *a)
{
    if (!a->known) {
        if (!have_piece(r, a)) {
            return false;
        }
        next_job(r, a, &a->next);
        a->known = true;
    }
    return has_room(a, &a->next) && a->marks < MARKS &&
           (!a->next.part.train || a->trains < TRAINS) && !is_early(r, a) &&
           (uint8_t)(a->head + 1u) != a->tail;
}

// ---- time ----

static double rate(struct axis *a, double now)
{
    while (a->plays != a->head && a->parts[a->plays].end <= now) {
        a->plays++;
    }
    if (a->plays == a->head) {
        return 0.0;
    }
    const struct part *part = &a->parts[a->plays];

    return part->end > part->begin ? part->steps / (part->end - part->begin) : 0.0;
}

// Share of the processor that interrupts take now; *until: when that may change.
static double interrupts(struct replay *r, double *until)
{
    const struct guarantee_costs *c = r->cost;
    double share = c->other_isr_share + c->edge_isr / r->edge_ticks +
                   r->board->bytes_per_tick * c->byte_isr +
                   r->board->asked_per_tick * c->request_byte;

    *until = r->now + period(r);
    for (uint32_t i = 0; i < r->axes; i++) {
        struct axis *a = &r->axis[i];
        double steps = rate(a, r->now);
        bool train = a->plays != a->head && a->parts[a->plays].train;
        share += steps * (train ? c->train_isr : c->step_isr);
        if (a->plays != a->head) {
            *until = fmin(*until, a->parts[a->plays].end);
        }
    }
    return fmin(share, 0.98);
}

// Let the main loop work for so many cycles.
static void spend(struct replay *r, double cycles)
{
    cycles *= r->board->margin;
    r->work += cycles;
    while (cycles > 0.0) {
        double until;
        double free = 1.0 - interrupts(r, &until);
        double ticks = cycles / free;
        if (until - r->now < 1.0) {
            until = r->now + 1.0;
        }
        if (r->now + ticks <= until) {
            r->now += ticks;
            return;
        }
        cycles -= (until - r->now) * free;
        r->now = until;
    }
}

static void lose(struct replay *r, const struct axis *a, double late_ticks)
{
    struct guarantee_verdict *v = r->verdict;

    if (v->follows) {
        v->follows = false;
        v->axis = (uint32_t)(a - r->axis);
        v->pixel = a->pixel;
        v->late_ticks = late_ticks;
    }
}

static double round_cost(const struct replay *r)
{
    return r->board->lead_edges != 0 ? r->cost->round_locked : r->cost->round;
}

// Take the edges that wait, and no more: edges that come faster than they can be taken are lost.
static void take_edges(struct replay *r)
{
    double waiting = floor(r->now / r->edge_ticks) + 1.0 - r->edges;
    double cycles = r->board->lead_edges != 0 ? r->cost->edge_locked : r->cost->edge;
    double most = r->several ? 8.0 : 5.0; // as many as the capture queue holds

    if (waiting > most) {
        lose(r, &r->axis[0], (waiting - most) * r->edge_ticks);
    }
    for (uint32_t left = waiting > 0.0 ? (uint32_t)waiting : 0; left != 0; left--) {
        r->edges += 1.0;
        spend(r, cycles);
    }
}

static bool is_made(const struct replay *r, const struct part *part)
{
    return part->end <= r->now;
}

static void advance(struct replay *r, struct axis *a)
{
    double cycles = r->cost->account;

    for (; a->tail != a->head && is_made(r, &a->parts[a->tail]); a->tail++) {
        const struct part *part = &a->parts[a->tail];
        cycles += part->account;
        a->used -= part->entries;
        a->marks -= part->mark ? 1u : 0u;
        a->trains -= part->train ? 1u : 0u;
    }
    spend(r, cycles);
}

static bool account_helps(const struct replay *r, const struct axis *a)
{
    return a->tail != a->head && is_made(r, &a->parts[a->tail]);
}

// ---- decoding ----

static void note_time(struct replay *r, struct axis *a)
{
    struct guarantee_verdict *v = r->verdict;
    double until;
    double request_ticks = r->cost->request / (1.0 - interrupts(r, &until));
    double slack = a->end - 2.0 * a->interval - r->now - request_ticks;

    if (slack < v->slack_ticks) {
        v->slack_ticks = slack;
    }
    if (slack < 0.0) {
        lose(r, a, -slack);
    }
}

static void write_part(struct replay *r, struct axis *a)
{
    const struct job *job = &a->next;

    if (r->started) {
        spend(r, job->cycles);
        note_time(r, a);
    }
    a->parts[a->head++] = job->part;
    a->used += job->part.entries;
    a->marks += job->part.mark ? 1u : 0u;
    a->trains += job->part.train ? 1u : 0u;
    a->end = job->part.end;
    a->interval = job->interval;
    a->done += job->part.steps;
    if (job->last) {
        a->begun = false;
    }
    a->known = false;
}

// One call of the decoder: up to a number of units. Returns the units used; 0: nothing to do.
static double decode(struct replay *r, struct axis *a)
{
    double units = 0.0;

    spend(r, r->cost->call);
    while (units < CALL_UNITS && r->verdict->follows && may_write(r, a)) {
        units += a->next.units;
        write_part(r, a);
    }
    return units;
}

static struct axis *first_to_end(struct replay *r, uint32_t out)
{
    struct axis *found = NULL;

    for (uint32_t i = 0; i < r->axes; i++) {
        struct axis *a = &r->axis[i];
        if ((out & 1u << i) != 0 || (found != NULL && found->end <= a->end)) {
            continue;
        }
        if (!may_write(r, a)) {
            if (!account_helps(r, a)) {
                continue;
            }
            advance(r, a);
            if (!may_write(r, a)) {
                continue;
            }
        }
        found = a;
    }
    return found;
}

// Those of the axes that are out for which an account finds nothing new.
static uint32_t still_out(const struct replay *r, uint32_t out)
{
    for (uint32_t i = 0; i < r->axes; i++) {
        if (account_helps(r, &r->axis[i])) {
            out &= ~(1u << i);
        }
    }
    return out;
}

static bool decode_in_turn(struct replay *r)
{
    double since = r->now;
    uint32_t out = 0;
    bool any = false;

    if (!r->several) {
        advance(r, &r->axis[0]);
        return decode(r, &r->axis[0]) > 0.0;
    }
    do {
        take_edges(r);
        out = still_out(r, out);
        struct axis *a = first_to_end(r, out);
        if (a == NULL || !r->verdict->follows) {
            break;
        }
        advance(r, a);
        double units = decode(r, a);
        if (units <= 0.0 || (units < CALL_UNITS && !a->line->smooth)) {
            out |= 1u << (a - r->axis);
        }
        any = any || units > 0.0;
    } while (r->now - since < r->board->round_ticks);
    return any;
}

static void look_after(struct replay *r)
{
    spend(r, round_cost(r));
    take_edges(r);
    r->rounds++;
    for (uint32_t i = 0; i < r->axes; i++) {
        struct axis *a = &r->axis[i];
        if (account_helps(r, a) &&
            (a->marks >= MARKS || a->used > RING_ENTRIES - ROOM_TO_BEGIN)) {
            advance(r, a);
        }
    }
}

// The end of the wait of all axes, at the earliest.
static double next_event(struct replay *r)
{
    double next = NEVER_TICKS;

    for (uint32_t i = 0; i < r->axes; i++) {
        const struct axis *a = &r->axis[i];
        if (a->tail != a->head && !(a->over && !a->begun)) {
            next = fmin(next, a->parts[a->tail].end);
        }
    }
    if (r->board->lead_edges != 0) {
        next = fmin(next, (floor(r->now / r->edge_ticks) + 1.0) * r->edge_ticks);
    }
    return next;
}

static bool all_written(const struct replay *r)
{
    for (uint32_t i = 0; i < r->axes; i++) {
        if (!r->axis[i].over || r->axis[i].begun) {
            return false;
        }
    }
    return true;
}

static void fill(struct replay *r)
{
    for (uint32_t i = 0; i < r->axes; i++) {
        struct axis *a = &r->axis[i];
        while (may_write(r, a)) {
            write_part(r, a);
        }
    }
}

static void begin(struct replay *r, const struct guarantee_axis *line, uint32_t lines)
{
    r->axes = lines;
    r->several = r->board->axes > 1;
    r->edge_ticks = period(r) / r->board->divider;
    for (uint32_t i = 0; i < lines; i++) {
        struct axis *a = &r->axis[i];
        a->line = &line[i];
        a->shifted = line[i].backlash_steps != 0 && line[i].line_speed != 0;
        a->count = INT32_MIN;
    }
}

void guarantee_demand(const struct guarantee_costs *costs,
                      const struct guarantee_board *board,
                      const struct guarantee_axis *line,
                      double *decode,
                      double *account)
{
    struct replay *r = calloc(1, sizeof *r);
    struct job job;

    *decode = 0.0;
    *account = 0.0;
    if (r == NULL) {
        return;
    }
    r->cost = costs;
    r->board = board;
    begin(r, line, 1);
    struct axis *a = &r->axis[0];
    while (have_piece(r, a)) {
        next_job(r, a, &job);
        *decode += job.cycles;
        *account += job.part.account;
        a->done += job.part.steps;
        a->begun = !job.last;
    }
    free(r);
}

void guarantee_judge(const struct guarantee_costs *costs,
                     const struct guarantee_board *board,
                     const struct guarantee_axis *line,
                     uint32_t lines,
                     struct guarantee_verdict *verdict)
{
    struct replay *r = calloc(1, sizeof *r);

    *verdict = (struct guarantee_verdict){.follows = true, .slack_ticks = NEVER_TICKS};
    if (r == NULL) {
        verdict->follows = false;
        return;
    }
    r->cost = costs;
    r->board = board;
    r->verdict = verdict;
    begin(r, line, lines);
    fill(r);
    r->started = true;
    while (verdict->follows && !all_written(r)) {
        look_after(r);
        if (!decode_in_turn(r) && verdict->follows) {
            double next = next_event(r);
            if (next > r->now && next < NEVER_TICKS) {
                r->now = next;
                spend(r, round_cost(r));
            }
        }
    }
    verdict->busy = r->now > 0.0 ? r->work / r->now : 0.0;
    free(r);
}
