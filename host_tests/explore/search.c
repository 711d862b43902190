// SPDX-License-Identifier: MIT
#include "explore/search.h"

#include <string.h>

#include "explore/board.h"
#include "explore/judge.h"
#include "explore/part.h"
#include "explore/program.h"
#include "explore/report.h"
#include "explore/states.h"

#define CHOICES (1u << PART_EVENT_KINDS)

struct search {
    struct search_counts *counts;
    struct steps steps;
    struct layer now, next;     // states between pieces
    struct layer here, further; // states at points of the current piece
    struct layer judged;        // states at rest
    struct state power_on;
    const struct state *from; // the current state
    struct step last;         // the step taken from there
    uint16_t scenario;        // read by functions that program_call() calls
};

// The search's data are not part of the program's memory.
static struct search *search;

static void save(struct state *state)
{
    state->size = program_size();
    state->memory = allocate(NULL, state->size);
    program_save(state->memory);
}

static void restore(const struct state *state)
{
    program_restore(state->memory, state->size);
}

// The program is in a state of this layer; it came there from search->from.
static void arrive(struct layer *layer, const uint8_t *left, bool with_step)
{
    uint64_t hash[2];

    program_hash(hash);
    for (unsigned event = 0; event < PART_EVENT_KINDS; event++) {
        hash[0] = hash[0] * 31u + left[event];
    }
    struct state *state = layer_find(layer, hash);
    if (state->memory == NULL) {
        save(state);
        state->step = search->from->step;
        if (with_step) {
            state->step = steps_add(&search->steps, &search->last);
        }
        memcpy(state->left, left, sizeof state->left);
        search->counts->states++;
    }
    state->schedules += search->from->schedules;
}

// Choose these events if they are possible at the point of the restored state, and take them from
// those that are left.
static bool choose(uint8_t events, uint8_t *left)
{
    for (unsigned event = 0; event < PART_EVENT_KINDS; event++) {
        if ((events & 1u << event) != 0) {
            if (left[event] == 0 || !part_possible((enum part_event)event)) {
                return false;
            }
            left[event]--;
        }
    }
    return true;
}

// Run the program from search->from to the next point or to the end of the piece.
static enum program_verdict go_on(uint8_t piece, uint8_t events, bool disturbed)
{
    uint8_t left[PART_EVENT_KINDS];

    memcpy(left, search->from->left, sizeof left);
    restore(search->from);
    if (!choose(events, left)) {
        return PROGRAM_FINE;
    }
    struct program_task task = {
        .piece = piece,
        .events = events,
        .to_the_end = left[PART_PERIOD_ENDS] + left[PART_PIN_CHANGES] == 0,
        .disturbed = disturbed || events != 0,
    };
    search->last = (struct step){
        .parent = search->from->step,
        .point = part.points,
        .piece = STEP_NO_PIECE,
        .events = events,
        .pc = part.pc,
    };
    search->counts->runs++;
    enum program_verdict verdict = program_go(&task);
    if (verdict == PROGRAM_AT_POINT) {
        arrive(&search->further, left, events != 0);
        return PROGRAM_FINE;
    }
    search->last.piece = piece;
    if (verdict == PROGRAM_OVER) {
        arrive(&search->next, left, true);
        return PROGRAM_FINE;
    }
    return verdict;
}

static enum program_verdict train_piece(const struct state *before, uint8_t piece)
{
    search->from = before;
    enum program_verdict verdict = go_on(piece, 0, false);

    while (verdict == PROGRAM_FINE && search->further.count != 0) {
        layer_swap(&search->here, &search->further);
        uint32_t choices = search->here.count * CHOICES;
        for (uint32_t i = 0; verdict == PROGRAM_FINE && i < choices; i++) {
            search->from = &search->here.states[i / CHOICES];
            bool disturbed = search->from->step != before->step;
            verdict = go_on(piece, (uint8_t)(i % CHOICES), disturbed);
        }
    }
    layer_empty(&search->here);
    return verdict;
}

// Run the pieces from `first` on, each from every state of the layer.
static enum program_verdict segment_pieces(uint8_t first, uint8_t pieces)
{
    enum program_verdict verdict = PROGRAM_FINE;

    for (uint32_t i = 0; i < search->now.count; i++) {
        for (uint8_t piece = 0; verdict == PROGRAM_FINE && piece < pieces; piece++) {
            verdict = train_piece(&search->now.states[i], (uint8_t)(first + piece));
        }
    }
    if (verdict == PROGRAM_FINE) {
        layer_swap(&search->now, &search->next);
    }
    return verdict;
}

// True when this state was judged already, with any number of events left.
static bool was_judged(const struct state *state)
{
    uint64_t hash[2];
    uint32_t before = search->judged.count;

    restore(state);
    program_hash(hash);
    (void)layer_find(&search->judged, hash);
    return search->judged.count == before;
}

static enum program_verdict judge_layer(void)
{
    enum program_verdict verdict = PROGRAM_FINE;

    for (uint32_t i = 0; verdict == PROGRAM_FINE && i < search->now.count; i++) {
        search->from = &search->now.states[i];
        if (!was_judged(search->from)) {
            search->counts->judged++;
            verdict = program_call(judge_rest);
        }
    }
    return verdict;
}

static void prepare(void)
{
    if (!board_prepare(search->scenario)) {
        judge_broken(JUDGE_SCENARIO);
    }
    part_point();
}

// Make the state from which every sequence begins.
static enum program_verdict begin(const struct search_limits *limits)
{
    const uint64_t none[2] = {0, 0};

    layer_empty(&search->now);
    layer_empty(&search->next);
    layer_empty(&search->here);
    layer_empty(&search->further);
    layer_empty(&search->judged);
    search->steps.count = 0;
    search->from = NULL;
    restore(&search->power_on);
    enum program_verdict verdict = program_call(prepare);
    struct state *state = layer_find(&search->now, none);
    save(state);
    state->step = STEP_FIRST;
    state->schedules = 1;
    state->left[PART_PERIOD_ENDS] = limits->periods;
    state->left[PART_PIN_CHANGES] = limits->pins;
    return verdict;
}

static enum program_verdict explore(const struct search_limits *limits, bool *at_rest)
{
    enum program_verdict verdict = begin(limits);
    double sequences = 1;

    for (uint8_t i = 0; verdict == PROGRAM_FINE && i < limits->actions; i++) {
        sequences *= board_actions();
        search->counts->sequences += sequences;
        verdict = segment_pieces(0, board_actions());
        if (verdict == PROGRAM_FINE) {
            verdict = segment_pieces(PROGRAM_ROUND, 1);
        }
        if (verdict == PROGRAM_FINE) {
            verdict = judge_layer();
            *at_rest = verdict != PROGRAM_FINE;
        }
    }
    for (uint32_t i = 0; verdict == PROGRAM_FINE && i < search->now.count; i++) {
        search->counts->schedules += search->now.states[i].schedules;
    }
    search->counts->points = program_most_points();
    return verdict;
}

static void open_search(void)
{
    struct search *opened = allocate(NULL, sizeof *opened);

    memset(opened, 0, sizeof *opened);
    // This must come before anything is saved, because the pointer itself lies in saved memory.
    search = opened;
    program_open();
    save(&search->power_on);
}

bool search_scenario(uint16_t scenario,
                     const struct search_limits *limits,
                     struct search_counts *counts,
                     FILE *report)
{
    enum program_verdict verdict = PROGRAM_SHARES;
    bool at_rest = false;

    if (search == NULL) {
        open_search();
    }
    search->scenario = scenario;
    search->counts = counts;
    while (verdict == PROGRAM_SHARES) {
        memset(counts, 0, sizeof *counts);
        verdict = explore(limits, &at_rest);
    }
    if (verdict == PROGRAM_FINE) {
        return true;
    }
    report_begin(report, scenario);
    if (search->from != NULL) {
        report_way(report, &search->steps, search->from->step);
        report_last(report, at_rest ? NULL : &search->last);
    }
    board_describe(report);
    return false;
}
