// SPDX-License-Identifier: MIT
#include "explore/search.h"

#include <setjmp.h>
#include <stdlib.h>
#include <string.h>
#include <ucontext.h>

#include "explore/board.h"
#include "explore/judge.h"
#include "explore/part.h"

#define ROUND        254u // a piece that is no action
#define EVENTS       255u // no piece: events at a point of one
#define NO_PARENT    UINT32_MAX
#define IDLE_AT_REST 8u   // periods without an edge
#define REST_MAX     300u // periods until an axis rests
#define STACK_BYTES  65536u
// Below the block that alloca() gives there is nothing of a frame but the call in work.
#define STACK_MARGIN 64u
#define STACK_CLEARED 2048u

enum verdict {
    VERDICT_POINT = 1,
    VERDICT_OVER, // of the piece
    VERDICT_BROKEN,
    VERDICT_UNSHARED,
};

// How a state was first reached.
struct step {
    uint32_t parent;
    uint16_t point;
    uint8_t piece;
    uint8_t events; // bit n: enum part_event n, at that point
    const void *pc;
};

// A state to go on from. Its memory is followed by the used part of its stack.
struct state {
    uint64_t hash[2];
    double schedules;
    uint8_t *memory;
    uint32_t stack_bytes;
    uint32_t step;
    uint8_t left[PART_EVENT_KINDS];
};

struct layer {
    struct state *states;
    uint32_t count, room;
    uint32_t *slots; // of a hash table, number + 1
    uint32_t slot_count;
};

struct search {
    jmp_buf out; // of the program, to the search
    const char *broken;
    struct search_counts *counts;
    size_t memory_bytes;
    struct step *steps;
    uint32_t step_count, step_room;
    struct layer now, next;     // between pieces
    struct layer here, further; // at points of the piece in work
    struct layer judged;        // at rest
    uint8_t *stack;
    const struct state *from;
    uint8_t piece;
    uint8_t events;   // to happen at the point in work
    bool on_stack;    // the program runs on its own stack
    bool to_the_end;  // nothing is left to be placed: points are passed
    bool undisturbed; // nothing was placed in this piece
    struct step last; // in a report
};

// Where the program goes on, a part of the state.
struct place {
    jmp_buf at;
    uint8_t *low; // of its stack
};

// Not a part of the state: allocated, and set before the first state is saved.
static struct search *search;
static struct place place;

static void *allocate(void *old, size_t bytes)
{
    void *room = realloc(old, bytes);

    if (room == NULL) {
        (void)fputs("pixstep-explore: out of memory\n", stderr);
        exit(2);
    }
    return room;
}

// Leaving the program and going on with it.

static __attribute__((noinline)) void leave(enum verdict verdict)
{
    place.low = (uint8_t *)__builtin_alloca(16) - STACK_MARGIN;
    if (_setjmp(place.at) == 0) {
        _longjmp(search->out, (int)verdict);
    }
}

// Apart, because it returns twice.
static __attribute__((noinline)) enum verdict go(void)
{
    int verdict = _setjmp(search->out);

    if (verdict == 0) {
        search->on_stack = true;
        _longjmp(place.at, 1);
    }
    search->on_stack = false;
    return (enum verdict)verdict;
}

static void run_pieces(void)
{
    for (;;) {
        // What a piece leaves behind in its accounts is no part of a state between two.
        part.points = 0;
        part.pc = NULL;
        part.looking = false;
        leave(VERDICT_OVER);
        if (search->piece == ROUND) {
            board_round();
        } else {
            board_act(search->piece);
        }
        part_point();
        judge_between();
        if (part.points > search->counts->points) {
            search->counts->points = part.points;
        }
    }
}

static void open_stack(void)
{
    ucontext_t program;
    ucontext_t back;

    search->stack = allocate(NULL, STACK_BYTES);
    memset(search->stack, 0, STACK_BYTES);
    (void)getcontext(&program);
    program.uc_stack.ss_sp = search->stack;
    program.uc_stack.ss_size = STACK_BYTES;
    program.uc_link = NULL;
    makecontext(&program, run_pieces, 0);
    if (_setjmp(search->out) == 0) {
        (void)swapcontext(&back, &program);
    }
}

void search_point(void)
{
    if (!search->on_stack || search->to_the_end) {
        return;
    }
    leave(VERDICT_POINT);
    for (uint8_t event = 0; event < PART_EVENT_KINDS; event++) {
        if ((search->events & 1u << event) != 0) {
            part_happen((enum part_event)event);
        }
    }
}

__attribute__((noinline)) void search_clear_stack(void)
{
    if (search->on_stack) {
        uint8_t *end = (uint8_t *)__builtin_alloca(16) - 2u * STACK_MARGIN;
        memset(end - STACK_CLEARED, 0, STACK_CLEARED);
    }
}

bool search_undisturbed(void)
{
    return search->undisturbed;
}

_Noreturn void judge_broken(const char *rule)
{
    search->broken = rule;
    _longjmp(search->out, VERDICT_BROKEN);
}

void judge_unshared(const volatile void *address)
{
    part_share(address, 1);
    _longjmp(search->out, VERDICT_UNSHARED);
}

// States.

static uint64_t mix(uint64_t hash, uint64_t word)
{
    __uint128_t product = (__uint128_t)(hash ^ word) * 0x9E3779B97F4A7C15u;

    return (uint64_t)product ^ (uint64_t)(product >> 64);
}

static void hash_bytes(const uint8_t *bytes, size_t count, uint64_t hash[2])
{
    for (size_t at = 0; at + 8u <= count; at += 8u) {
        uint64_t word = 0;
        memcpy(&word, &bytes[at], sizeof word);
        hash[0] = mix(hash[0], word);
        hash[1] = mix(hash[1] + 0xA4093822299F31D0u, ~word);
    }
}

static uint8_t *stack_end(void)
{
    return search->stack + STACK_BYTES;
}

static void restore(const struct state *state)
{
    memcpy(part_memory, state->memory, search->memory_bytes);
    memcpy(stack_end() - state->stack_bytes,
           &state->memory[search->memory_bytes],
           state->stack_bytes);
}

static void save(struct state *state)
{
    state->stack_bytes = (uint32_t)(stack_end() - place.low);
    state->memory = allocate(NULL, search->memory_bytes + state->stack_bytes);
    memcpy(state->memory, part_memory, search->memory_bytes);
    memcpy(&state->memory[search->memory_bytes], place.low, state->stack_bytes);
}

static uint32_t add_step(const struct step *step)
{
    if (search->step_count == search->step_room) {
        search->step_room = 2u * search->step_room + 1024u;
        search->steps = allocate(search->steps, search->step_room * sizeof *search->steps);
    }
    search->steps[search->step_count] = *step;
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

static void swap_layers(struct layer *now, struct layer *next)
{
    struct layer done = *now;

    *now = *next;
    *next = done;
    empty(next);
}

static void hash_now(uint64_t hash[2])
{
    hash[0] = 0x243F6A8885A308D3u;
    hash[1] = 0x13198A2E03707344u;
    hash_bytes(part_memory, search->memory_bytes, hash);
    hash_bytes(place.low, (size_t)(stack_end() - place.low), hash);
}

// The program is in a state of this layer. `step` is how it came there, if it came by one.
static void arrive(struct layer *layer,
                   const struct state *from,
                   const uint8_t left[PART_EVENT_KINDS],
                   uint32_t parent,
                   const struct step *step)
{
    uint64_t hash[2];

    hash_now(hash);
    for (uint8_t i = 0; i < PART_EVENT_KINDS; i++) {
        hash[0] = mix(hash[0], left[i]);
    }
    struct state *state = find(layer, hash);
    if (state->memory == NULL) {
        save(state);
        state->step = parent;
        if (step != NULL) {
            struct step taken = *step;
            taken.parent = parent;
            state->step = add_step(&taken);
        }
        memcpy(state->left, left, sizeof state->left);
        search->counts->states++;
    }
    state->schedules += from->schedules;
}

// Running.

static uint8_t sum(const uint8_t left[PART_EVENT_KINDS])
{
    return (uint8_t)(left[PART_PERIOD_ENDS] + left[PART_PIN_CHANGES]);
}

// These events are possible at the point of the restored state; they are taken from what is left.
static bool choose(uint8_t events, uint8_t left[PART_EVENT_KINDS])
{
    search->events = events;
    for (uint8_t event = 0; event < PART_EVENT_KINDS; event++) {
        if ((events & 1u << event) != 0) {
            if (left[event] == 0 || !part_possible((enum part_event)event)) {
                return false;
            }
            left[event]--;
        }
    }
    return true;
}

// From a state at a point, or before the piece, to the next point or the end.
static bool go_on(const struct state *from, uint8_t events)
{
    uint8_t left[PART_EVENT_KINDS];

    memcpy(left, from->left, sizeof left);
    restore(from);
    if (!choose(events, left)) {
        return true;
    }
    struct step here = {
        .piece = EVENTS, .events = events, .point = part.points, .pc = part.pc};
    search->last = here;
    search->to_the_end = sum(left) == 0;
    search->undisturbed = search->undisturbed && events == 0;
    search->counts->runs++;
    enum verdict verdict = go();
    if (verdict == VERDICT_POINT) {
        arrive(&search->further, from, left, from->step, events != 0 ? &here : NULL);
        return true;
    }
    if (verdict != VERDICT_OVER) {
        return false;
    }
    uint32_t parent = from->step;
    struct step over = {.piece = search->piece};
    if (events != 0) {
        over.events = events;
        over.point = here.point;
        over.pc = here.pc;
    }
    arrive(&search->next, from, left, parent, &over);
    return true;
}

static bool run_piece(const struct state *from, uint8_t piece)
{
    search->piece = piece;
    search->from = from;
    search->undisturbed = true;
    if (!go_on(from, 0)) {
        return false;
    }
    while (search->further.count != 0) {
        swap_layers(&search->here, &search->further);
        for (uint32_t i = 0; i < search->here.count; i++) {
            search->from = &search->here.states[i];
            for (uint8_t events = 0; events < 1u << PART_EVENT_KINDS; events++) {
                search->undisturbed = search->here.states[i].step == from->step;
                if (!go_on(&search->here.states[i], events)) {
                    return false;
                }
            }
        }
    }
    empty(&search->here);
    return true;
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
    restore(state);
    search->counts->judged++;
    int verdict = _setjmp(search->out);
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

    restore(state);
    hash_now(hash);
    (void)find(&search->judged, hash);
    return search->judged.count == before;
}

static bool judge_layer(void)
{
    for (uint32_t i = 0; i < search->now.count; i++) {
        const struct state *state = &search->now.states[i];
        if (!was_judged(state) && !judge_state(state)) {
            search->from = state;
            return false;
        }
    }
    return true;
}

// Reporting.

static const char *const event_names[PART_EVENT_KINDS] = {
    [PART_PERIOD_ENDS] = "a period ends",
    [PART_PIN_CHANGES] = "the emergency stop's pin changes",
};

static void report_step(FILE *report, const struct step *step)
{
    if (step->events != 0) {
        (void)fprintf(report, "    at point %u (%p):", step->point, step->pc);
        for (uint8_t event = 0; event < PART_EVENT_KINDS; event++) {
            if ((step->events & 1u << event) != 0) {
                (void)fprintf(report, " %s;", event_names[event]);
            }
        }
        (void)fputc('\n', report);
    }
    if (step->piece != EVENTS) {
        (void)fprintf(report,
                      "  %s\n",
                      step->piece == ROUND ? "a round of the main loop"
                                           : board_action(step->piece));
    }
}

static void report_path(FILE *report, uint32_t step)
{
    if (step != NO_PARENT) {
        report_path(report, search->steps[step].parent);
        report_step(report, &search->steps[step]);
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
        struct step last = search->last;
        last.piece = search->piece;
        report_step(report, &last);
    }
    board_describe(report);
}

// Searching.

static bool expand(uint8_t first_piece, uint8_t pieces)
{
    for (uint32_t i = 0; i < search->now.count; i++) {
        for (uint8_t piece = 0; piece < pieces; piece++) {
            if (!run_piece(&search->now.states[i], (uint8_t)(first_piece + piece))) {
                return false;
            }
        }
    }
    swap_layers(&search->now, &search->next);
    return true;
}

// Where every sequence begins.
static bool begin(uint8_t scenario, const struct search_limits *limits)
{
    empty(&search->now);
    empty(&search->next);
    empty(&search->here);
    empty(&search->further);
    empty(&search->judged);
    search->step_count = 0;
    search->from = NULL;
    search->piece = ROUND;
    int verdict = _setjmp(search->out);
    if (verdict != 0) {
        return false;
    }
    if (!board_prepare(scenario)) {
        judge_broken("the scenario does not come");
    }
    part_point();
    part.points = 0;
    part.pc = NULL;
    part.looking = false;
    uint64_t hash[2] = {0, 0};
    struct state *state = find(&search->now, hash);
    save(state);
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

static struct state *power_on(void)
{
    static struct state state;

    if (search == NULL) {
        part_deaf = allocate(NULL, sizeof *part_deaf);
        *part_deaf = false;
        search = allocate(NULL, sizeof *search);
        memset(search, 0, sizeof *search);
        search->memory_bytes = (size_t)(part_memory_end - part_memory);
        board_power_on();
        open_stack();
        save(&state);
        // It is part of what was saved.
        memcpy(&state.memory[(uint8_t *)&state - part_memory], &state, sizeof state);
    }
    return &state;
}

bool search_scenario(uint8_t scenario,
                     const struct search_limits *limits,
                     struct search_counts *counts,
                     FILE *report)
{
    bool at_rest = false;

    do {
        restore(power_on());
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
