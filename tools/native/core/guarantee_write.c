// SPDX-License-Identifier: MIT
#include "guarantee_write.h"

#include <math.h>

#include "guarantee_time.h"

#define ROOM_TO_BEGIN 64.0
#define ROOM_IN_CURVE 40.0
#define ROOM_TO_GO_ON 20.0
#define TRAINS        2u
#define BATCH_ALONE   120.0 // most steps of a batch of a single axis,
#define BATCH_LOW     16.0  // and where its ring is low
#define BEGUN_MOST    60.0  // steps, by which a batch may have to be early
#define WAITING_LEADS 4u
#define LOAD_TICKS    1000.0 // most that an interrupt waits, and takes

// A batch is no larger than the room that is left, and where it may be large than what the ring
// still has: it shows when all of it is made.
static double batch_most(const struct loop *r, const struct axis *a)
{
    double room = RING_ENTRIES - a->used;
    double most = r->several ? BATCH : fmin(fmax(a->used, BATCH_LOW), BATCH_ALONE);

    return fmax(fmin(room, most), 1.0);
}

// Room in the ring that the next part waits for. A call of the decoder begins only where there is
// much of it, and goes on with little.
static double least_room(const struct loop *r, const struct axis *a, bool goes_on)
{
    enum kind kind = a->walk.kind;
    bool in_curve = !r->several || (kind == CURVE && a->walk.done > 0.0);
    double least = in_curve ? ROOM_IN_CURVE : ROOM_TO_BEGIN;

    if (goes_on) {
        least = ROOM_TO_GO_ON;
    }

    if (kind == CURVE || kind == SINGLES) {
        return least;
    }
    return fmin(fmax(least, a->next.part.entries), RING_ENTRIES);
}

static double room_of(const struct axis *a)
{
    return RING_ENTRIES + 8.0 - a->used;
}

// The pixel begins at the edge before its number, counted from line zero; before that none has
// come.
static double begins_at(const struct walk *w)
{
    return (double)w->pixel - (w->shifted ? 2.0 : 1.0);
}

static bool is_early(const struct loop *r, double begins_px)
{
    const struct guarantee_board *b = r->board;
    double lead = b->lead_edges;

    if (b->lead_edges == 0) {
        return false;
    }
    // A line that waits goes on once more when it gets its place, an edge or more before line zero.
    if (r->several) {
        double waiting = r->started ? 0.0 : (lead - 1.0) * WAITING_LEADS + 1.0;
        lead = fmax(lead + b->more_edges, waiting);
    }
    return begins_px * b->divider - (r->edges - 1.0) > lead;
}

bool loop_is_early(const struct loop *r, const struct axis *a)
{
    return a->walk.done <= 0.0 && is_early(r, begins_at(&a->walk));
}

// Take what is written next, a->next; false when the line is over.
static bool take_next(const struct loop *r, struct axis *a)
{
    if (!a->known) {
        if (!walk_piece(&a->walk, r->board)) {
            return false;
        }
        a->known = true;
        a->most = 0.0;
    }
    if (fabs(a->most - batch_most(r, a)) > 0.5) {
        a->most = batch_most(r, a);
        walk_job(&a->walk, r->cost, r->board, a->most, &a->next);
    }
    return true;
}

// True when a->next has to wait for something else than room or a train.
static bool must_wait(const struct loop *r, const struct axis *a)
{
    return a->marks >= MARKS || loop_is_early(r, a) || (uint8_t)(a->head + 1u) == a->tail;
}

bool loop_may_begin(const struct loop *r, struct axis *a, bool goes_on)
{
    return take_next(r, a) && !must_wait(r, a) && room_of(a) >= least_room(r, a, goes_on);
}

bool loop_awaits_train(const struct axis *a)
{
    return a->next.part.train && a->trains >= TRAINS;
}

bool loop_may_write(const struct loop *r, struct axis *a)
{
    return loop_may_begin(r, a, false) && !loop_awaits_train(a);
}

bool loop_may_decode(const struct loop *r, struct axis *a)
{
    if (!loop_may_begin(r, a, false)) {
        return false;
    }
    return !loop_awaits_train(a) || (!a->opened && a->next.begin_units > 0.0);
}

// After the longest request a single axis has a round before it decodes, and an edge may come in
// it. Its ring is low then, and batches of its curves are short: what it takes to begin a batch
// must be made up for by what the batch has over what it costs.
static double spare_ticks(struct loop *r, const struct axis *a)
{
    const struct guarantee_costs *c = r->cost;
    const struct part *part = &a->next.part;
    double until;

    if (r->several) {
        return r->board->spare_ticks;
    }
    double slower = r->board->margin / (1.0 - loop_interrupts(r, &until));
    double begin = slower * (loop_round_cost(r) + loop_edge_cost(r) + c->turn +
                             c->account + c->call + c->short_batch);
    double spare = fmax(r->board->spare_ticks, begin);

    if (a->walk.kind != CURVE || part->steps < BATCH_LOW) {
        return spare;
    }
    double lasts = (part->end - part->begin) / part->steps;
    double takes = slower * a->next.cycles / part->steps;
    double most = lasts * BEGUN_MOST;

    if (lasts > takes) {
        most = fmin(begin * lasts / (lasts - takes), most);
    }
    return fmax(spare, most);
}

// What is written now must be there before the interrupt begins the last period of what stands in
// front of it, since it then loads the next one; the longest request is still to come.
static void note_time(struct loop *r, const struct axis *a)
{
    struct guarantee_verdict *v = r->verdict;
    double load = fmin(a->last_ticks, LOAD_TICKS);
    double slack = a->end - a->last_ticks - load - r->now - loop_request_ticks(r);
    double spare = spare_ticks(r, a);

    if (slack < v->slack_ticks) {
        v->slack_ticks = slack;
    }
    if (slack < spare) {
        loop_lose(r, a, spare - slack);
    }
}

// Where the decoder cannot go on behind a wait, the wait is written, too.
static void move_front(const struct loop *r, struct axis *a)
{
    const struct job *job = &a->next;
    bool stops = a->marks >= MARKS || is_early(r, begins_at(&a->walk) + 1.0);

    if (job->part.steps <= 0.0 && stops) {
        a->walk.waited = 0.0;
        a->end = job->part.end;
        a->last_ticks = fmin(job->part.end - job->part.begin, PERIOD_TICKS + CHUNK_TICKS);
    } else if (!job->waits) {
        a->end = job->front;
        a->last_ticks = job->last_ticks;
    }
}

void loop_write_part(struct loop *r, struct axis *a)
{
    const struct job *job = &a->next;

    if (r->started) {
        loop_spend(r, job->cycles + (a->opened ? 0.0 : job->begin_cycles));
        note_time(r, a);
    }
    a->parts[a->head++] = job->part;
    a->used += job->part.entries;
    a->marks += job->part.mark ? 1u : 0u;
    a->trains += job->part.train ? 1u : 0u;
    a->others += job->part.other ? 1u : 0u;
    walk_pass(&a->walk, job);
    move_front(r, a);
    a->known = false;
    a->opened = false;
}
