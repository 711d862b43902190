// SPDX-License-Identifier: MIT
#include "guarantee_loop.h"

#include <math.h>
#include <stddef.h>

#include "guarantee_account.h"
#include "guarantee_time.h"
#include "guarantee_write.h"

// Budget of a call of the firmware's decoder, in units of a step of a flat curve (round.c).
#define CALL_UNITS 120.0
// A single axis is accounted for every so many rounds; any one where so many entries are made.
#define ADVANCE_ROUNDS 4u
#define URGENT_ENTRIES 64.0
#define MOST_EDGES     0.9 // of the time that interrupts leave, for taking edges

// ---- a round ----

// Begin the piece that is next, if it is not. Returns the units used.
static double open(struct loop *r, struct axis *a)
{
    if (a->opened || a->next.begin_units <= 0.0) {
        return 0.0;
    }
    loop_spend(r, a->next.begin_cycles);
    a->opened = true;
    return a->next.begin_units;
}

// One call of the decoder: up to a number of units. Returns the units used; 0: nothing to do.
static double decode(struct loop *r, struct axis *a)
{
    double units = 0.0;

    loop_spend(r, r->cost->call);
    while (units < CALL_UNITS && r->verdict->follows &&
           loop_may_begin(r, a, units > 0.0)) {
        units += open(r, a);
        if (units >= CALL_UNITS || loop_awaits_train(a)) {
            break;
        }
        units += a->next.units;
        loop_write_part(r, a);
    }
    if (units < CALL_UNITS && a->known && a->marks < MARKS && loop_is_early(r, a)) {
        loop_spend(r, r->cost->early);
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
        if (!loop_may_decode(r, a)) {
            if (!loop_account_helps(r, a)) {
                continue;
            }
            loop_advance(r, a);
            if (!loop_may_decode(r, a)) {
                continue;
            }
        }
        found = a;
    }
    return found;
}

// Those of the axes that are out whose train is not over meanwhile: one that waits for room is out
// until the round ends.
static uint32_t still_out(const struct loop *r, uint32_t out)
{
    for (uint32_t i = 0; i < r->axes; i++) {
        const struct axis *a = &r->axis[i];
        if (a->known && loop_awaits_train(a) && loop_account_helps(r, a)) {
            out &= ~(1u << i);
        }
    }
    return out;
}

static bool decode_alone(struct loop *r)
{
    struct axis *a = &r->axis[0];

    if (!loop_may_write(r, a)) {
        return false;
    }
    loop_spend(r, r->cost->turn);
    loop_advance(r, a);
    return decode(r, a) > 0.0;
}

static bool decode_in_turn(struct loop *r)
{
    double since = r->now;
    uint32_t out = 0;
    uint32_t calls = 0;
    bool any = false;

    do {
        loop_take_edges(r);
        out = still_out(r, out);
        struct axis *a = first_to_end(r, out);
        if (a == NULL || !r->verdict->follows) {
            break;
        }
        loop_spend(r, r->cost->turn);
        loop_advance(r, a);
        double units = decode(r, a);
        if (units <= 0.0 || (units < CALL_UNITS && !a->walk.line->smooth)) {
            out |= 1u << (a - r->axis);
        }
        any = any || units > 0.0;
        calls++;
    } while (calls != r->board->most_calls && r->now - since < r->board->round_ticks);
    return any;
}

// True when an account is advanced out of turn: much is made, the marks are full, or, with several
// axes, a train is over that the decoder waits for.
static bool is_urgent(const struct loop *r, const struct axis *a)
{
    double made = loop_made_entries(r, a);
    bool awaited = r->several && a->known && loop_awaits_train(a);

    return made >= URGENT_ENTRIES || (made > 0.0 && (a->marks >= MARKS || awaited));
}

static void look_after(struct loop *r)
{
    loop_spend(r, loop_round_cost(r));
    loop_take_edges(r);
    r->rounds++;
    for (uint32_t i = 0; i < r->axes; i++) {
        struct axis *a = &r->axis[i];
        bool due = !r->several && r->rounds % ADVANCE_ROUNDS == 0;
        if (is_urgent(r, a) || (due && loop_made_entries(r, a) > 0.0)) {
            loop_advance(r, a);
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
    double free_cycles = r->edge_ticks * (1.0 - loop_interrupts(r, &until));

    if (loop_edge_cost(r) * r->board->margin > MOST_EDGES * free_cycles) {
        loop_lose(r, &r->axis[0], r->edge_ticks);
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
        while (loop_may_write(r, a)) {
            loop_write_part(r, a);
        }
    }
}

void loop_begin(struct loop *loop, const struct guarantee_axis *line, uint32_t lines)
{
    loop->axes = lines;
    loop->several = loop->board->axes > 1;
    loop->edge_ticks = loop_period(loop) / loop->board->divider;
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
