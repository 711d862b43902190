// SPDX-License-Identifier: MIT
#include "explore/search.h"

#include <setjmp.h>
#include <stdlib.h>
#include <string.h>

#include "explore/board.h"
#include "explore/judge.h"
#include "explore/part.h"

#define ROUND       255u // a piece that is no action
#define NO_PARENT   UINT32_MAX
#define IDLE_AT_REST 8u    // periods without an edge
#define REST_MAX     300u  // periods until an axis rests
#define NAMES_MAX    4096u

enum verdict { VERDICT_FINE = 1, VERDICT_BROKEN, VERDICT_UNSHARED };

// How a state was first reached.
struct step {
    uint32_t parent;
    uint8_t piece;
    uint8_t count;
    struct part_placed placed[PART_EVENTS_MAX];
};

// A state that waits to be gone on from.
struct state {
    uint64_t hash[2];
    uint32_t step;
    uint8_t left[PART_EVENT_KINDS];
    double schedules;
    uint8_t *memory;
};

struct layer {
    struct state *states;
    uint32_t count, room;
    uint32_t *slots; // of a hash table, number + 1
    uint32_t slot_count;
};

struct search {
    jmp_buf out;
    const char *broken;
    struct search_counts *counts;
    size_t memory_bytes;
    struct step *steps;
    uint32_t step_count, step_room;
    struct layer now, next;
    struct layer judged; // at rest
    uint8_t possible[PART_EVENTS_MAX + 1][PART_POINTS_MAX];
    // The piece in work.
    const struct state *from;
    uint8_t piece;
};

// Not a part of the state: allocated, and set before the first state is saved.
static struct search *search;

static void *allocate(void *old, size_t bytes)
{
    void *room = realloc(old, bytes);

    if (room == NULL) {
        (void)fputs("pixstep-explore: out of memory\n", stderr);
        exit(2);
    }
    return room;
}

_Noreturn void judge_broken(const char *rule)
{
    search->broken = rule;
    longjmp(search->out, VERDICT_BROKEN);
}

void judge_unshared(const volatile void *address)
{
    part_share(address, 1);
    longjmp(search->out, VERDICT_UNSHARED);
}

// States.

static uint64_t mix(uint64_t hash, uint64_t word)
{
    __uint128_t product = (__uint128_t)(hash ^ word) * 0x9E3779B97F4A7C15u;

    return (uint64_t)product ^ (uint64_t)(product >> 64);
}

static void hash_memory(const uint8_t *memory, size_t bytes, uint64_t seed, uint64_t hash[2])
{
    hash[0] = 0x243F6A8885A308D3u ^ seed;
    hash[1] = 0x13198A2E03707344u + seed;
    for (size_t at = 0; at + 8u <= bytes; at += 8u) {
        uint64_t word = 0;
        memcpy(&word, &memory[at], sizeof word);
        hash[0] = mix(hash[0], word);
        hash[1] = mix(hash[1] + 0xA4093822299F31D0u, ~word);
    }
}

static void restore(const uint8_t *memory)
{
    memcpy(part_memory, memory, search->memory_bytes);
}

static uint8_t *save(void)
{
    uint8_t *memory = allocate(NULL, search->memory_bytes);

    memcpy(memory, part_memory, search->memory_bytes);
    return memory;
}

static uint32_t add_step(const struct part_run *run, uint32_t parent, uint8_t piece)
{
    if (search->step_count == search->step_room) {
        search->step_room = 2u * search->step_room + 1024u;
        search->steps = allocate(search->steps, search->step_room * sizeof *search->steps);
    }
    struct step *step = &search->steps[search->step_count];
    *step = (struct step){.parent = parent, .piece = piece, .count = run->count};
    memcpy(step->placed, run->placed, sizeof step->placed);
    return search->step_count++;
}

static void rehash(struct layer *layer)
{
    layer->slot_count = layer->slot_count == 0 ? 4096u : 4u * layer->slot_count;
    layer->slots = allocate(layer->slots, layer->slot_count * sizeof *layer->slots);
    memset(layer->slots, 0, layer->slot_count * sizeof *layer->slots);
    for (uint32_t i = 0; i < layer->count; i++) {
        uint32_t slot = (uint32_t)layer->states[i].hash[0] & (layer->slot_count - 1u);
        while (layer->slots[slot] != 0) {
            slot = (slot + 1u) & (layer->slot_count - 1u);
        }
        layer->slots[slot] = i + 1u;
    }
}

// The state of this hash in a layer; a new one without memory if it is not there.
static struct state *find(struct layer *layer, const uint64_t hash[2])
{
    if (2u * layer->count >= layer->slot_count) {
        rehash(layer);
    }
    uint32_t slot = (uint32_t)hash[0] & (layer->slot_count - 1u);
    while (layer->slots[slot] != 0) {
        struct state *state = &layer->states[layer->slots[slot] - 1u];
        if (state->hash[0] == hash[0] && state->hash[1] == hash[1]) {
            return state;
        }
        slot = (slot + 1u) & (layer->slot_count - 1u);
    }
    if (layer->count == layer->room) {
        layer->room = 2u * layer->room + 256u;
        layer->states = allocate(layer->states, layer->room * sizeof *layer->states);
    }
    struct state *state = &layer->states[layer->count];
    layer->count++;
    layer->slots[slot] = layer->count;
    *state = (struct state){.hash = {hash[0], hash[1]}};
    return state;
}

static void empty(struct layer *layer)
{
    for (uint32_t i = 0; i < layer->count; i++) {
        free(layer->states[i].memory);
    }
    layer->count = 0;
    if (layer->slots != NULL) {
        memset(layer->slots, 0, layer->slot_count * sizeof *layer->slots);
    }
}

// The program's memory now is a state of the next layer.
static void arrive(const uint8_t left[PART_EVENT_KINDS])
{
    uint64_t hash[2];
    uint64_t seed = 1u + (uint64_t)left[0] * 256u + left[1];

    hash_memory(part_memory, search->memory_bytes, seed, hash);
    struct state *state = find(&search->next, hash);
    if (state->memory == NULL) {
        state->memory = save();
        state->step = add_step(part_run, search->from->step, search->piece);
        memcpy(state->left, left, sizeof state->left);
        search->counts->states++;
    }
    state->schedules += search->from->schedules;
}

// Running.

static void run_piece(void)
{
    if (search->piece == ROUND) {
        board_round();
    } else {
        board_act(search->piece);
    }
    part_point();
    judge_between();
}

static bool start_run(void)
{
    restore(search->from->memory);
    part_run->next = 0;
    part_run->points = 0;
    search->counts->runs++;
    enum verdict verdict = (enum verdict)setjmp(search->out);
    if (verdict == 0) {
        run_piece();
    }
    return verdict == 0;
}

// Run the piece with the events placed so far; then with one more, wherever one can be.
static bool place(uint8_t count, const uint8_t left[PART_EVENT_KINDS])
{
    part_run->count = count;
    if (!start_run()) {
        return false;
    }
    arrive(left);
    uint16_t points = part_run->points;
    if (points > search->counts->points) {
        search->counts->points = points;
    }
    uint8_t *possible = search->possible[count];
    memcpy(possible, part_run->possible, points);
    uint16_t first = count == 0 ? 0 : part_run->placed[count - 1u].point;

    for (uint16_t point = first; count < PART_EVENTS_MAX && point < points; point++) {
        for (uint8_t event = 0; event < PART_EVENT_KINDS; event++) {
            bool again = count != 0 && point == first &&
                         event <= part_run->placed[count - 1u].event;
            if (left[event] == 0 || again || (possible[point] & 1u << event) == 0) {
                continue;
            }
            uint8_t fewer[PART_EVENT_KINDS];
            memcpy(fewer, left, sizeof fewer);
            fewer[event]--;
            part_run->placed[count] = (struct part_placed){point, event};
            if (!place((uint8_t)(count + 1u), fewer)) {
                return false;
            }
        }
    }
    return true;
}

static bool go_on(const struct state *state, uint8_t piece)
{
    search->from = state;
    search->piece = piece;
    return place(0, state->left);
}

// Judging.

static void come_to_rest(void)
{
    uint32_t quiet = 0;

    for (uint32_t i = 0; quiet < IDLE_AT_REST; i++) {
        int32_t position = judged.position;
        if (i == REST_MAX) {
            judge_broken(JUDGE_RUNAWAY);
        }
        board_idle();
        quiet = judged.position == position ? quiet + 1u : 0;
    }
}

static void judge_rest(void)
{
    come_to_rest();
    if (part_estop_pressed() && !board_estop_recorded()) {
        judge_broken(JUDGE_ESTOP);
    }
    if (board_position() != judged.position) {
        judge_broken(JUDGE_POSITION);
    }
    if (!board_recovers()) {
        judge_broken(JUDGE_STUCK);
    }
}

static bool judge_state(const struct state *state)
{
    restore(state->memory);
    part_run->count = 0;
    part_run->next = 0;
    search->counts->judged++;
    enum verdict verdict = (enum verdict)setjmp(search->out);
    if (verdict == 0) {
        judge_rest();
    }
    return verdict == 0;
}

// Whether a state of this memory was judged already, however many events are left.
static bool was_judged(const struct state *state)
{
    uint64_t hash[2];
    uint32_t before = search->judged.count;

    hash_memory(state->memory, search->memory_bytes, 0, hash);
    (void)find(&search->judged, hash);
    return search->judged.count == before;
}

static bool judge_layer(void)
{
    for (uint32_t i = 0; i < search->now.count; i++) {
        const struct state *state = &search->now.states[i];
        if (!was_judged(state) && !judge_state(state)) {
            search->from = state;
            part_run->count = 0;
            return false;
        }
    }
    return true;
}

// Reporting.

static void report_step(FILE *report, const struct step *step)
{
    (void)fprintf(report,
                  "  %s",
                  step->piece == ROUND ? "a round of the main loop" : board_action(step->piece));
    for (uint8_t i = 0; i < step->count; i++) {
        (void)fprintf(report,
                      "; at point %u %s",
                      step->placed[i].point,
                      step->placed[i].event == PART_PERIOD_ENDS ? "a period ends"
                                                                : "the pin changes");
    }
    (void)fputc('\n', report);
}

static void report_path(FILE *report, uint32_t step)
{
    if (step != NO_PARENT) {
        report_path(report, search->steps[step].parent);
        report_step(report, &search->steps[step]);
    }
}

// Where the program was at the points at which events are placed.
static void report_places(FILE *report)
{
    for (uint8_t i = 0; i < part_run->count; i++) {
        (void)fprintf(report, "  point %u: %p\n", part_run->placed[i].point,
                      part_run->pcs[part_run->placed[i].point]);
    }
}

static void report_broken(FILE *report, uint8_t scenario, bool at_rest)
{
    (void)fprintf(report, "%s\nfrom \"%s\":\n", search->broken, board_scenario(scenario));
    if (search->from != NULL) {
        report_path(report, search->from->step);
    }
    if (at_rest) {
        (void)fputs("  then idle periods\n", report);
    } else {
        struct step last = {.piece = search->piece, .count = part_run->count};
        memcpy(last.placed, part_run->placed, sizeof last.placed);
        report_step(report, &last);
        report_places(report);
    }
    board_describe(report);
}

// Searching.

static void swap_layers(void)
{
    struct layer done = search->now;

    search->now = search->next;
    search->next = done;
    empty(&search->next);
}

static bool expand(uint8_t first_piece, uint8_t pieces)
{
    for (uint32_t i = 0; i < search->now.count; i++) {
        for (uint8_t piece = 0; piece < pieces; piece++) {
            if (!go_on(&search->now.states[i], (uint8_t)(first_piece + piece))) {
                return false;
            }
        }
    }
    swap_layers();
    return true;
}

// Where every sequence begins.
static bool begin(uint8_t scenario, const struct search_limits *limits)
{
    empty(&search->now);
    empty(&search->next);
    empty(&search->judged);
    search->step_count = 0;
    search->from = NULL;
    part_run->count = 0;
    part_run->next = 0;
    part_run->points = 0;
    search->piece = ROUND;
    enum verdict verdict = (enum verdict)setjmp(search->out);
    if (verdict != 0) {
        return false;
    }
    if (!board_prepare(scenario)) {
        judge_broken("the scenario does not come");
    }
    part_point();
    uint64_t hash[2] = {0, 0};
    struct state *state = find(&search->now, hash);
    state->memory = save();
    state->step = NO_PARENT;
    state->schedules = 1;
    state->left[PART_PERIOD_ENDS] = limits->periods;
    state->left[PART_PIN_CHANGES] = limits->pins;
    return true;
}

static bool explore(uint8_t scenario, const struct search_limits *limits, bool *at_rest)
{
    double sequences = 1;

    if (!begin(scenario, limits)) {
        return false;
    }
    for (uint8_t i = 0; i < limits->actions; i++) {
        sequences *= board_actions();
        search->counts->sequences += sequences;
        if (!expand(0, board_actions()) || !expand(ROUND, 1)) {
            return false;
        }
        *at_rest = true;
        if (!judge_layer()) {
            return false;
        }
        *at_rest = false;
    }
    for (uint32_t i = 0; i < search->now.count; i++) {
        search->counts->schedules += search->now.states[i].schedules;
    }
    return true;
}

static void open_search(void)
{
    static uint8_t *power_on;

    if (search == NULL) {
        part_run = allocate(NULL, sizeof *part_run);
        memset(part_run, 0, sizeof *part_run);
        search = allocate(NULL, sizeof *search);
        memset(search, 0, sizeof *search);
        search->memory_bytes = (size_t)(part_memory_end - part_memory);
        board_power_on();
        power_on = save();
        // The pointer itself is part of what was saved.
        memcpy(&power_on[(uint8_t *)&power_on - part_memory], &power_on, sizeof power_on);
    }
    restore(power_on);
}

bool search_scenario(uint8_t scenario,
                     const struct search_limits *limits,
                     struct search_counts *counts,
                     FILE *report)
{
    bool at_rest = false;

    do {
        open_search();
        memset(counts, 0, sizeof *counts);
        search->counts = counts;
        search->broken = NULL;
        if (explore(scenario, limits, &at_rest)) {
            return true;
        }
        // An interrupt shares more than was known: again, with points there too.
    } while (search->broken == NULL);
    report_broken(report, scenario, at_rest);
    return false;
}
