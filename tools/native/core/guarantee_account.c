// SPDX-License-Identifier: MIT
#include "guarantee_account.h"

#include <math.h>

#include "guarantee_time.h"

#define EDGE_ENTRY_CYCLES 16.0 // of step_ring_sum()
// Edges that the capture queue holds, of boards of several axes and of one.
#define EDGES_SEVERAL 8.0
#define EDGES_ONE     5.0

// Entries of the clock's axis that are added up to place an edge that is taken now: those since the
// edge before, which the account has come to, or since the beginning of a pixel that it takes as a
// whole. A pixel's end has its own time.
static double entries_to_edge(const struct loop *r)
{
    const struct axis *a = &r->axis[0];
    double made = 0.0;

    if (r->board->lead_edges != 0 && r->board->divider == 1) {
        return 0.0;
    }
    for (uint8_t i = a->tail; i != a->head && a->parts[i].begin < r->now; i++) {
        const struct part *part = &a->parts[i];
        double from = part->whole ? part->begin : fmax(part->begin, r->placed);
        double to = fmin(part->end, r->now);
        if (!part->train && to > from && !(part->whole && part->end <= r->now)) {
            made += part->entries * (to - from) / (part->end - part->begin);
        }
    }
    return made;
}

void loop_take_edges(struct loop *r)
{
    double waiting = floor(r->now / r->edge_ticks) + 1.0 - r->edges;
    double cycles = loop_edge_cost(r);
    double most = r->several ? EDGES_SEVERAL : EDGES_ONE;

    if (waiting > most || loop_request_ticks(r) > most * r->edge_ticks) {
        loop_lose(r, &r->axis[0], (waiting - most) * r->edge_ticks);
    }
    for (uint32_t left = waiting > 0.0 ? (uint32_t)waiting : 0; left != 0; left--) {
        r->edges += 1.0;
        loop_spend(r, cycles + EDGE_ENTRY_CYCLES * entries_to_edge(r));
        r->placed = r->now;
    }
}

bool loop_account_helps(const struct loop *r, const struct axis *a)
{
    return a->tail != a->head && a->parts[a->tail].end <= r->now;
}

double loop_made_entries(const struct loop *r, const struct axis *a)
{
    double made = 0.0;

    for (uint8_t i = a->tail; i != a->head && a->parts[i].end <= r->now; i++) {
        made += a->parts[i].entries;
    }
    return made;
}

void loop_advance(struct loop *r, struct axis *a)
{
    double cycles = r->cost->account;

    if (r->several && !loop_account_helps(r, a)) {
        return;
    }
    for (; loop_account_helps(r, a); a->tail++) {
        const struct part *part = &a->parts[a->tail];
        cycles += part->account + (a->trains != 0 ? r->cost->account_train_px : 0.0);
        a->used -= part->entries;
        a->marks -= part->mark ? 1u : 0u;
        a->trains -= part->train ? 1u : 0u;
        a->others -= part->other ? 1u : 0u;
    }
    loop_spend(r, cycles);
}
