// SPDX-License-Identifier: MIT

#include "pin_flaws.h"

#include <string.h>

#include "cpu_clock.h"

#define NOISE_PLACE 1000U // behind those of the boards' memories
#define HIGH_US     5U
#define HIGH_MIN    4U
#define GAP_CYCLES  2U // low at least between two pulses
#define THOUSAND    1000U

void pin_flaws_init(struct pin_flaws *p, uint64_t seed, unsigned board)
{
    memset(p, 0, sizeof *p);
    noise_seed(&p->random, seed, NOISE_PLACE + board);
}

bool pin_flaws_add(struct pin_flaws *p,
                   enum pin_flaw_kind kind,
                   uint64_t nth,
                   uint32_t phase)
{
    if (p->flaws == PIN_FLAWS_MAX) {
        return false;
    }
    p->flaw[p->flaws++] =
        (struct pin_flaw){.kind = kind, .edge = p->edges + nth - 1, .phase = phase};
    return true;
}

bool pin_flaws_pulse(struct pin_flaws *p, uint64_t cycle)
{
    unsigned at = p->pulses;

    if (p->pulses == PIN_FLAWS_MAX) {
        return false;
    }
    while (at > 0 && p->pulse[at - 1] > cycle) {
        p->pulse[at] = p->pulse[at - 1];
        at--;
    }
    p->pulse[at] = cycle;
    p->pulses++;
    return true;
}

void pin_flaws_displace(struct pin_flaws *p, struct pixel_pulse *pulse)
{
    uint64_t high = pulse->fall - pulse->rise;

    if (p->jitter_cycles > 0) {
        pulse->rise += noise_next(&p->random) % (2U * (uint64_t)p->jitter_cycles + 1);
        pulse->rise -= p->jitter_cycles;
    }
    if (pulse->rise < p->last_fall + GAP_CYCLES) {
        pulse->rise = p->last_fall + GAP_CYCLES;
    }
    pulse->fall = pulse->rise + high;
}

// Performs the flaws of this edge, and forgets them. True if the edge is missing.
static bool perform(struct pin_flaws *p, const struct pixel_pulse *pulse, uint64_t period)
{
    bool missing = false;
    unsigned kept = 0;

    for (unsigned i = 0; i < p->flaws; i++) {
        const struct pin_flaw *flaw = &p->flaw[i];

        if (flaw->edge != p->edges) {
            p->flaw[kept++] = *flaw;
        } else if (flaw->kind == PIN_FLAW_MISS) {
            missing = true;
        } else {
            // A full list loses the edge: as many false ones are to come already.
            (void)pin_flaws_pulse(p, pulse->rise + period * flaw->phase / THOUSAND);
        }
    }
    p->flaws = kept;
    return missing;
}

bool pin_flaws_pass(struct pin_flaws *p, const struct pixel_pulse *pulse, uint64_t period)
{
    bool missing = false;

    if (pulse->kind == PIXEL_EDGE_TRUE) {
        missing = perform(p, pulse, period);
        p->edges++;
    }
    if (!missing) {
        p->last_fall = pulse->fall;
    }
    return !missing;
}

static uint64_t take_first(struct pin_flaws *p)
{
    uint64_t first = p->pulse[0];

    p->pulses--;
    memmove(&p->pulse[0], &p->pulse[1], p->pulses * sizeof p->pulse[0]);
    return first;
}

bool pin_flaws_false(struct pin_flaws *p,
                     uint64_t before,
                     uint64_t limit,
                     struct pixel_pulse *pulse)
{
    while (p->pulses > 0 && p->pulse[0] < before) {
        uint64_t rise = take_first(p);
        uint64_t fall;

        if (rise < p->last_fall + GAP_CYCLES) {
            rise = p->last_fall + GAP_CYCLES;
        }
        fall = rise + cpu_clock_cycles_of_us(HIGH_US);
        if (fall + GAP_CYCLES > limit) {
            fall = limit - GAP_CYCLES;
        }
        if (rise + HIGH_MIN <= fall && fall < limit) {
            *pulse = (struct pixel_pulse){
                .rise = rise, .fall = fall, .kind = PIXEL_EDGE_FALSE};
            p->last_fall = fall;
            return true;
        }
    }
    return false;
}
