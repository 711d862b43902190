// SPDX-License-Identifier: MIT
#include "guarantee_loop.h"

#include <math.h>
#include <stddef.h>

#define ROOM_TO_BEGIN 64.0
#define ROOM_IN_CURVE 40.0
#define ROOM_TO_GO_ON 20.0
#define MARKS         15u
#define TRAINS        2u
#define BATCH_ALONE   120.0 // most steps of a batch of a single axis,
#define BATCH_LOW     16.0  // and where its ring is low
#define BEGUN_MOST    60.0  // steps, by which a batch may have to be early
// Budget of a call of the firmware's decoder, in units of a step of a flat curve (round.c).
#define CALL_UNITS    120.0
#define WAITING_LEADS 4u
#define NEVER_TICKS   1e300
// A single axis is accounted for every so many rounds; any one where so many entries are made.
#define ADVANCE_ROUNDS    4u
#define URGENT_ENTRIES    64.0
#define LOAD_TICKS        1000.0 // most that an interrupt waits, and takes
#define MOST_BUSY         0.98   // of the interrupts: some time is always left
#define MOST_EDGES        0.9    // of the time that these leave, for taking edges
#define EDGE_ENTRY_CYCLES 16.0   // of step_ring_sum()
// More than of other edges: some 1,000 on a 1284P, 620 on a Mega.
#define EDGE_IN_TRAIN_CYCLES 1000.0
// Edges that the capture queue holds, of boards of several axes and of one.
#define EDGES_SEVERAL 8.0
#define EDGES_ONE     5.0

static double period(const struct loop *r)
{
    return r->board->pixel_ticks;
}

// ---- what may be written ----

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

static bool is_early(const struct loop *r, const struct axis *a)
{
    const struct guarantee_board *b = r->board;
    double lead = b->lead_edges;

    if (b->lead_edges == 0 || a->walk.done > 0.0) {
        return false;
    }
    // A line that waits goes on once more when it gets its place, an edge or more before line zero.
    if (r->several) {
        double waiting = r->started ? 0.0 : (lead - 1.0) * WAITING_LEADS + 1.0;
        lead = fmax(lead + b->more_edges, waiting);
    }
    // The pixel begins at the edge before its number, counted from line zero; before that none has
    // come.
    double begins = (double)a->walk.pixel - (a->walk.shifted ? 2.0 : 1.0);

    return begins * b->divider - (r->edges - 1.0) > lead;
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

// True when a->next has to wait for something else than room.
static bool must_wait(const struct loop *r, const struct axis *a)
{
    return a->marks >= MARKS || (a->next.part.train && a->trains >= TRAINS) ||
           is_early(r, a) || (uint8_t)(a->head + 1u) == a->tail;
}

// True when the next part of an axis may be written now; `goes_on`: in the call that has written
// the one before.
static bool may_write_more(const struct loop *r, struct axis *a, bool goes_on)
{
    return take_next(r, a) && !must_wait(r, a) && room_of(a) >= least_room(r, a, goes_on);
}

static bool may_write(const struct loop *r, struct axis *a)
{
    return may_write_more(r, a, false);
}

// ---- time ----

// Steps a tick that the interrupt of an axis makes now.
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

static bool in_train(const struct axis *a)
{
    return a->plays != a->head && a->parts[a->plays].train;
}

// Share of the processor that interrupts take now; *until: when that may change.
static double interrupts(struct loop *r, double *until)
{
    const struct guarantee_costs *c = r->cost;
    double share = c->other_isr_share + c->edge_isr / r->edge_ticks +
                   r->board->bytes_per_tick * c->byte_isr +
                   r->board->asked_per_tick * c->request_byte;

    *until = r->now + period(r);
    for (uint32_t i = 0; i < r->axes; i++) {
        struct axis *a = &r->axis[i];
        double steps = rate(a, r->now);
        share += steps * (in_train(a) ? c->train_isr : c->step_isr);
        if (a->plays != a->head) {
            *until = fmin(*until, a->parts[a->plays].end);
        }
    }
    return fmin(share, MOST_BUSY);
}

// Let the main loop work for so many cycles.
static void spend(struct loop *r, double cycles)
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

// ---- being late ----

static void lose(struct loop *r, const struct axis *a, double late_ticks)
{
    struct guarantee_verdict *v = r->verdict;

    if (v->follows) {
        v->follows = false;
        v->axis = (uint32_t)(a - r->axis);
        v->pixel = a->walk.pixel;
        v->late_ticks = late_ticks;
    }
}

static double request_ticks(struct loop *r)
{
    double until;

    return r->cost->request / (1.0 - interrupts(r, &until));
}

static double round_cost(const struct loop *r)
{
    return r->board->lead_edges != 0 ? r->cost->round_locked : r->cost->round;
}

// Nobody has said which axis is the clock's. The place of an edge in its train takes a division.
static double edge_cost(const struct loop *r)
{
    double cycles = r->board->lead_edges != 0 ? r->cost->edge_locked : r->cost->edge;

    for (uint32_t i = 0; i < r->axes; i++) {
        if (in_train(&r->axis[i])) {
            return cycles + EDGE_IN_TRAIN_CYCLES;
        }
    }
    return cycles;
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
    double slower = r->board->margin / (1.0 - interrupts(r, &until));
    double begin = slower * (round_cost(r) + edge_cost(r) + c->turn + c->account +
                             c->call + c->short_batch);
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
    double slack = a->end - a->last_ticks - load - r->now - request_ticks(r);
    double spare = spare_ticks(r, a);

    if (slack < v->slack_ticks) {
        v->slack_ticks = slack;
    }

    if (slack < spare) {
        lose(r, a, spare - slack);
    }
}

// ---- edges and accounts ----

// Entries of the clock's axis between the edge before and one that is taken now. Within a pixel an
// edge is placed by their sum; a pixel's end has its own time.
static double entries_to_edge(const struct loop *r)
{
    const struct axis *a = &r->axis[0];
    double made = 0.0;

    if (r->board->lead_edges != 0 && r->board->divider == 1) {
        return 0.0;
    }
    for (uint8_t i = a->tail; i != a->head && a->parts[i].begin < r->now; i++) {
        const struct part *part = &a->parts[i];
        double from = fmax(part->begin, r->placed);
        double to = fmin(part->end, r->now);
        if (!part->train && to > from) {
            made += part->entries * (to - from) / (part->end - part->begin);
        }
    }
    return made;
}

// Take the edges that wait, and no more: edges that come faster than they can be taken are lost,
// and so are those for which there is no room in the queue after the longest request.
static void take_edges(struct loop *r)
{
    double waiting = floor(r->now / r->edge_ticks) + 1.0 - r->edges;
    double cycles = edge_cost(r);
    double most = r->several ? EDGES_SEVERAL : EDGES_ONE;

    if (waiting > most || request_ticks(r) > most * r->edge_ticks) {
        lose(r, &r->axis[0], (waiting - most) * r->edge_ticks);
    }
    for (uint32_t left = waiting > 0.0 ? (uint32_t)waiting : 0; left != 0; left--) {
        r->edges += 1.0;
        spend(r, cycles + EDGE_ENTRY_CYCLES * entries_to_edge(r));
        r->placed = r->now;
    }
}

static bool account_helps(const struct loop *r, const struct axis *a)
{
    return a->tail != a->head && a->parts[a->tail].end <= r->now;
}

// Entries that are made and can be accounted for: those of a part are free when all of them are
// made.
static double made_entries(const struct loop *r, const struct axis *a)
{
    double made = 0.0;

    for (uint8_t i = a->tail; i != a->head && a->parts[i].end <= r->now; i++) {
        made += a->parts[i].entries;
    }
    return made;
}

// Boards of several axes look only where something is made.
static void advance(struct loop *r, struct axis *a)
{
    double cycles = r->cost->account;

    if (r->several && !account_helps(r, a)) {
        return;
    }
    for (; account_helps(r, a); a->tail++) {
        const struct part *part = &a->parts[a->tail];
        cycles += part->account;
        a->used -= part->entries;
        a->marks -= part->mark ? 1u : 0u;
        a->trains -= part->train ? 1u : 0u;
    }
    spend(r, cycles);
}

// ---- decoding ----

static void write_part(struct loop *r, struct axis *a)
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
    a->last_ticks = job->last_ticks;
    walk_pass(&a->walk, job);
    a->known = false;
}

// One call of the decoder: up to a number of units. Returns the units used; 0: nothing to do.
static double decode(struct loop *r, struct axis *a)
{
    double units = 0.0;

    spend(r, r->cost->call);
    while (units < CALL_UNITS && r->verdict->follows &&
           may_write_more(r, a, units > 0.0)) {
        units += a->next.units;
        write_part(r, a);
    }
    if (units < CALL_UNITS && a->known && a->marks < MARKS && is_early(r, a)) {
        spend(r, r->cost->early);
    }
    return units;
}

static struct axis *first_to_end(struct loop *r, uint32_t out)
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
static uint32_t still_out(const struct loop *r, uint32_t out)
{
    for (uint32_t i = 0; i < r->axes; i++) {
        if (account_helps(r, &r->axis[i])) {
            out &= ~(1u << i);
        }
    }
    return out;
}

static bool decode_alone(struct loop *r)
{
    struct axis *a = &r->axis[0];

    if (!may_write(r, a)) {
        return false;
    }
    spend(r, r->cost->turn);
    advance(r, a);
    return decode(r, a) > 0.0;
}

static bool decode_in_turn(struct loop *r)
{
    double since = r->now;
    uint32_t out = 0;
    uint32_t calls = 0;
    bool any = false;

    do {
        take_edges(r);
        out = still_out(r, out);
        struct axis *a = first_to_end(r, out);
        if (a == NULL || !r->verdict->follows) {
            break;
        }
        spend(r, r->cost->turn);
        advance(r, a);
        double units = decode(r, a);
        if (units <= 0.0 || (units < CALL_UNITS && !a->walk.line->smooth)) {
            out |= 1u << (a - r->axis);
        }
        any = any || units > 0.0;
        calls++;
    } while (calls != r->board->most_calls && r->now - since < r->board->round_ticks);
    return any;
}

// True when an account is advanced out of turn: much is made, or the marks are full.
static bool is_urgent(const struct loop *r, const struct axis *a)
{
    double made = made_entries(r, a);

    return made >= URGENT_ENTRIES || (made > 0.0 && a->marks >= MARKS);
}

static void look_after(struct loop *r)
{
    spend(r, round_cost(r));
    take_edges(r);
    r->rounds++;
    for (uint32_t i = 0; i < r->axes; i++) {
        struct axis *a = &r->axis[i];
        bool due = !r->several && r->rounds % ADVANCE_ROUNDS == 0;
        if (is_urgent(r, a) || (due && made_entries(r, a) > 0.0)) {
            advance(r, a);
        }
    }
}

// ---- the whole ----

static bool is_over(const struct axis *a)
{
    return a->walk.over && !a->walk.begun;
}

// The end of the wait of all axes, at the earliest.
static double next_event(const struct loop *r)
{
    double next = NEVER_TICKS;

    for (uint32_t i = 0; i < r->axes; i++) {
        const struct axis *a = &r->axis[i];
        if (a->tail != a->head && !is_over(a)) {
            next = fmin(next, a->parts[a->tail].end);
        }
    }
    if (r->board->lead_edges != 0) {
        next = fmin(next, (floor(r->now / r->edge_ticks) + 1.0) * r->edge_ticks);
    }
    return next;
}

// Nothing is to be written until then: edges are taken as they come, and a single axis looks at its
// account only in one of some rounds after that.
static void wait_until(struct loop *r, double ticks)
{
    double until;
    double free_cycles = r->edge_ticks * (1.0 - interrupts(r, &until));

    if (edge_cost(r) * r->board->margin > MOST_EDGES * free_cycles) {
        lose(r, &r->axis[0], r->edge_ticks);
    }
    r->now = ticks;
    r->rounds = 0;
    r->edges = fmax(r->edges, floor(r->now / r->edge_ticks));
}

static bool all_written(const struct loop *r)
{
    for (uint32_t i = 0; i < r->axes; i++) {
        if (!is_over(&r->axis[i])) {
            return false;
        }
    }
    return true;
}

// The clock's edges must be taken until the last step, too.
static bool all_made(const struct loop *r)
{
    if (!all_written(r)) {
        return false;
    }
    for (uint32_t i = 0; i < r->axes; i++) {
        if (r->axis[i].end > r->now) {
            return false;
        }
    }
    return true;
}

// Before line zero there is time enough.
static void fill(struct loop *r)
{
    for (uint32_t i = 0; i < r->axes; i++) {
        struct axis *a = &r->axis[i];
        while (may_write(r, a)) {
            write_part(r, a);
        }
    }
}

void loop_begin(struct loop *loop, const struct guarantee_axis *line, uint32_t lines)
{
    loop->axes = lines;
    loop->several = loop->board->axes > 1;
    loop->edge_ticks = period(loop) / loop->board->divider;
    for (uint32_t i = 0; i < lines; i++) {
        walk_begin(&loop->axis[i].walk, &line[i]);
    }
}

void loop_play(struct loop *loop)
{
    fill(loop);
    loop->started = true;
    while (loop->verdict->follows && !all_made(loop)) {
        look_after(loop);
        bool any = loop->several ? decode_in_turn(loop) : decode_alone(loop);
        if (!any && loop->verdict->follows) {
            double next = next_event(loop);
            // It may come right after the look at it: a round goes by until the next.
            if (next > loop->now && next < NEVER_TICKS) {
                wait_until(loop, next);
            }
        }
    }
}
