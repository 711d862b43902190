// SPDX-License-Identifier: MIT

#include "contact.h"

#define SEED_PLACES 64U // more than a bench has switches
#define SEED_STEP   0x9E3779B97F4A7C15U

// Seeds that differ in one bit give sequences that have nothing in common (finalizer of
// splitmix64).
void contact_seed(struct contact *c, uint64_t seed, unsigned place)
{
    uint64_t mixed = (seed * SEED_PLACES + place + 1U) * SEED_STEP;

    mixed = (mixed ^ (mixed >> 30)) * 0xBF58476D1CE4E5B9U;
    mixed = (mixed ^ (mixed >> 27)) * 0x94D049BB133111EBU;
    c->random.state =
        (mixed ^ (mixed >> 31)) | 1U; // never 0, which xorshift does not leave
}

void contact_settle(struct contact *c, bool closed)
{
    c->closed = c->switch_closed = closed;
    c->change_first = c->change_last = 0;
    c->bounces = c->bounce_next = 0;
}

bool contact_follow(struct contact *c,
                    const struct contact_settings *s,
                    bool closed,
                    uint64_t cycle)
{
    unsigned at = c->change_last % CONTACT_CHANGES;

    if (c->switch_closed == closed) {
        return true;
    }
    if (c->change_last - c->change_first >= CONTACT_CHANGES) {
        return false;
    }
    c->switch_closed = closed;
    c->change[at].due = cycle + s->delay_ticks;
    c->change[at].closed = closed;
    c->change_last++;
    return true;
}

static uint64_t change_due(const struct contact *c)
{
    return (c->change_first == c->change_last)
               ? CONTACT_NEVER
               : c->change[c->change_first % CONTACT_CHANGES].due;
}

static uint64_t bounce_due(const struct contact *c)
{
    return (c->bounce_next == c->bounces) ? CONTACT_NEVER : c->bounce_at[c->bounce_next];
}

uint64_t contact_due(const struct contact *c)
{
    uint64_t change = change_due(c);
    uint64_t bounce = bounce_due(c);

    return (change < bounce) ? change : bounce;
}

// Inserts a bounce in the order of cycles. False if there is one in this cycle already.
static bool insert_bounce(struct contact *c, uint64_t cycle)
{
    unsigned at = c->bounces;

    while (at > 0 && c->bounce_at[at - 1] > cycle) {
        at--;
    }
    if (at > 0 && c->bounce_at[at - 1] == cycle) {
        return false;
    }
    for (unsigned i = c->bounces; i > at; i--) {
        c->bounce_at[i] = c->bounce_at[i - 1];
    }
    c->bounce_at[at] = cycle;
    c->bounces++;
    return true;
}

static void plan_bounces(struct contact *c,
                         const struct contact_settings *s,
                         uint64_t cycle)
{
    c->bounces = c->bounce_next = 0;
    while (c->bounces < s->bounce) {
        (void)insert_bounce(c, cycle + 1U + noise_next(&c->random) % s->bounce_ticks);
    }
}

bool contact_move(struct contact *c,
                  const struct contact_settings *s,
                  struct contact_edge *edge)
{
    bool before = c->closed;

    edge->cycle = contact_due(c);
    edge->bounce = change_due(c) != edge->cycle;
    if (edge->bounce) {
        c->bounce_next++;
        c->closed = !c->closed;
    } else {
        c->closed = c->change[c->change_first++ % CONTACT_CHANGES].closed;
        plan_bounces(c, s, edge->cycle);
    }
    return c->closed != before;
}
