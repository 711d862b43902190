// SPDX-License-Identifier: MIT
#include "guarantee_time.h"

#include <math.h>

#define MOST_BUSY 0.98 // of the interrupts: some time is always left
// More than of other edges: some 1,000 on a 1284P, 620 on a Mega.
#define EDGE_IN_TRAIN_CYCLES 1000.0

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

double loop_interrupts(struct loop *r, double *until)
{
    const struct guarantee_costs *c = r->cost;
    double share = c->other_isr_share + c->edge_isr / r->edge_ticks +
                   r->board->bytes_per_tick * c->byte_isr +
                   r->board->asked_per_tick * c->request_byte;

    *until = r->now + loop_period(r);
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

void loop_spend(struct loop *r, double cycles)
{
    cycles *= r->board->margin;
    r->work += cycles;
    while (cycles > 0.0) {
        double until;
        double free = 1.0 - loop_interrupts(r, &until);
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

double loop_request_ticks(struct loop *r)
{
    double until;

    return r->cost->request / (1.0 - loop_interrupts(r, &until));
}

double loop_round_cost(const struct loop *r)
{
    double cycles = r->board->lead_edges != 0 ? r->cost->round_locked : r->cost->round;

    for (uint32_t i = 0; i < r->axes; i++) {
        if (r->axis[i].others != 0) {
            return cycles + r->cost->round_unlike;
        }
    }
    return cycles;
}

// True when no more than one entry of the clock's axis comes between two edges. An edge that comes
// right before a step is placed by all of the account, which leaves nothing by which to place the
// next one quickly; more entries would.
static bool few_between(const struct loop *r)
{
    const struct axis *a = &r->axis[0];

    if (a->plays == a->head) {
        return false;
    }
    const struct part *part = &a->parts[a->plays];

    return !part->train && part->entries * r->edge_ticks <= part->end - part->begin;
}

// Nobody has said which axis is the clock's. The place of an edge in its train takes a division.
double loop_edge_cost(const struct loop *r)
{
    const struct guarantee_costs *c = r->cost;
    bool locked = r->board->lead_edges != 0;
    double cycles = locked ? c->edge_locked : c->edge;

    if (!locked && few_between(r)) {
        cycles += c->edge_few;
    }

    for (uint32_t i = 0; i < r->axes; i++) {
        if (in_train(&r->axis[i])) {
            return cycles + EDGE_IN_TRAIN_CYCLES;
        }
    }
    return cycles;
}
