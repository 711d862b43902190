// SPDX-License-Identifier: MIT

#include "control_clock.h"

#include <stdlib.h>
#include <string.h>

#include "cpu_clock.h"

#define PPM_LIMIT   1e5
#define JITTER_MOST 10000000U   // ns, of the clock
#define PIN_MOST    1000000U    // ns, of a pin
#define REST_MOST   3600000000U // us
#define NTH_MOST    1000000000U
#define PHASE_MOST  999U
#define US_PER_MS   1000.0
#define NS_PER_US   1000U

// ---- the clock ----

static bool set_on(struct control *c)
{
    c->bench->clock.on = true;
    return true;
}

static bool set_off(struct control *c)
{
    c->bench->clock.on = false;
    return true;
}

static bool drop(struct control *c)
{
    return control_number(c->word[2], UINT64_MAX / 2, &c->bench->clock.drop);
}

static bool set_ppm(struct control *c)
{
    char *end;
    double ppm = strtod(c->word[2], &end);

    if (end == c->word[2] || *end != '\0' || !(ppm > -PPM_LIMIT && ppm < PPM_LIMIT)) {
        control_answer("error '%s' is not a frequency error in ppm", c->word[2]);
        return false;
    }
    pixel_clock_set_ppm(&c->bench->clock, ppm);
    return true;
}

static bool set_hz(struct control *c)
{
    char *slash = strchr(c->word[2], '/');
    uint64_t num;
    uint64_t den = 1;

    if (slash != NULL) {
        *slash = '\0';
        if (!control_number(slash + 1, UINT32_MAX, &den)) {
            return false;
        }
    }
    if (!control_number(c->word[2], UINT32_MAX, &num)) {
        return false;
    }
    if (num == 0 || den == 0) {
        control_answer("error clock hz: a frequency above 0 is expected");
        return false;
    }
    pixel_clock_set_hz(&c->bench->clock, (uint32_t)num, (uint32_t)den, c->bench->cycle);
    return true;
}

static bool set_jitter(struct control *c)
{
    struct pixel_clock *clock = &c->bench->clock;
    uint64_t ns;

    if (!control_number(c->word[2], JITTER_MOST, &ns)) {
        return false;
    }
    pixel_clock_set_jitter(clock, (uint32_t)ns, clock->settings.jitter_rms_ns);
    return true;
}

static bool set_jitter_rms(struct control *c)
{
    struct pixel_clock *clock = &c->bench->clock;
    uint64_t ns;

    if (!control_number(c->word[2], JITTER_MOST, &ns)) {
        return false;
    }
    pixel_clock_set_jitter(clock, clock->settings.jitter_ns, (uint32_t)ns);
    return true;
}

static bool rest(struct control *c)
{
    uint64_t us;

    if (!control_number(c->word[2], REST_MOST, &us)) {
        return false;
    }
    pixel_clock_rest(&c->bench->clock, cpu_clock_cycles_of_us(us));
    return true;
}

static bool set_gate(struct control *c)
{
    uint64_t edges;
    uint64_t us;

    if (!control_number(c->word[2], UINT32_MAX, &edges) ||
        !control_number(c->word[3], REST_MOST, &us)) {
        return false;
    }
    pixel_clock_set_gate(&c->bench->clock, (uint32_t)edges, (double)us / US_PER_MS);
    return true;
}

// ---- one board's pin ----

// The number of an edge to come, which the fourth word names.
static bool read_nth(struct control *c, uint64_t *nth)
{
    if (!control_number(c->word[3], NTH_MOST, nth)) {
        return false;
    }
    if (*nth == 0) {
        control_answer("error edge: the next edge is number 1");
        return false;
    }
    return true;
}

static bool add_flaw(struct pin_flaws *pin,
                     enum pin_flaw_kind kind,
                     uint64_t nth,
                     uint64_t phase)
{
    if (!pin_flaws_add(pin, kind, nth, (uint32_t)phase)) {
        control_answer("error more than %d flaws wait for their edges", PIN_FLAWS_MAX);
        return false;
    }
    return true;
}

static struct pin_flaws *pin_of(struct control *c, const struct board *board)
{
    return &c->bench->pin[board->index];
}

static bool miss(struct control *c)
{
    const struct board *board = control_board(c);
    uint64_t nth;

    return board != NULL && read_nth(c, &nth) &&
           add_flaw(pin_of(c, board), PIN_FLAW_MISS, nth, 0);
}

static bool add(struct control *c)
{
    const struct board *board = control_board(c);
    uint64_t nth;
    uint64_t phase;

    return board != NULL && read_nth(c, &nth) &&
           control_number(c->word[4], PHASE_MOST, &phase) &&
           add_flaw(pin_of(c, board), PIN_FLAW_ADD, nth, phase);
}

static bool add_double(struct control *c)
{
    const struct board *board = control_board(c);
    uint64_t nth;
    struct pin_flaws *pin;

    if (board == NULL || !read_nth(c, &nth)) {
        return false;
    }
    pin = pin_of(c, board);
    return add_flaw(pin, PIN_FLAW_ADD, nth, pixel_clock_false_phase(&pin->random));
}

static bool pulse(struct control *c)
{
    const struct board *board = control_board(c);
    uint64_t cycle;
    bool later;

    if (board == NULL || !control_at(c, 3, &later, &cycle)) {
        return false;
    }
    if (!pin_flaws_pulse(pin_of(c, board), cycle)) {
        control_answer("error more than %d false edges are to come", PIN_FLAWS_MAX);
        return false;
    }
    return true;
}

static bool set_pin_jitter(struct control *c)
{
    const struct board *board = control_board(c);
    uint64_t ns;

    if (board == NULL || !control_number(c->word[3], PIN_MOST, &ns)) {
        return false;
    }
    pin_of(c, board)->jitter_cycles = (uint32_t)(cpu_clock_cycles_of_us(ns) / NS_PER_US);
    return true;
}

// ---- words ----

// A change that a word names; it answers itself if it returns false.
struct change {
    const char *name;
    int words_min, words_max; // of the whole command
    bool (*make)(struct control *c);
};

static const struct change clock_changes[] = {
    {"on", 2, 2, set_on},
    {"off", 2, 2, set_off},
    {"drop", 3, 3, drop},
    {"ppm", 3, 3, set_ppm},
    {"hz", 3, 3, set_hz},
    {"jitter", 3, 3, set_jitter},
    {"jitter-rms", 3, 3, set_jitter_rms},
    {"rest", 3, 3, rest},
    {"gate", 4, 4, set_gate},
    {NULL, 0, 0, NULL},
};

static const struct change edge_changes[] = {
    {"miss", 4, 4, miss},
    {"add", 5, 5, add},
    {"double", 4, 4, add_double},
    {"pulse", 3, 5, pulse},
    {"jitter", 4, 4, set_pin_jitter},
    {NULL, 0, 0, NULL},
};

static void make_change(struct control *c,
                        const struct change *change,
                        const char *name,
                        const char *forms)
{
    while (change->name != NULL && strcmp(change->name, name) != 0) {
        change++;
    }
    if (change->name == NULL || c->words < change->words_min ||
        c->words > change->words_max) {
        control_answer("error %s '%s': %s", c->word[0], name, forms);
    } else if (change->make(c)) {
        control_answer("ok");
    }
}

static void do_clock(struct control *c)
{
    make_change(c,
                clock_changes,
                c->word[1],
                "on, off, drop N, ppm X, hz N/D, jitter NS, jitter-rms NS, rest US or "
                "gate EDGES US");
}

static void do_edge(struct control *c)
{
    make_change(c,
                edge_changes,
                c->word[2],
                "miss N, add N PHASE, double N, pulse [at CYCLE] or jitter NS");
}

const struct command control_clock_commands[] = {
    {"clock", 2, 4, do_clock},
    {"edge", 3, 5, do_edge},
    {NULL, 0, 0, NULL},
};
