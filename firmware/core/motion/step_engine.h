// SPDX-License-Identifier: MIT
// What the step interrupt does, in C. On the AVR an assembly handler does the frequent case (a
// plain period) and calls step_engine_next() for the rest; natively the planner and the tests call
// it for everything, so both consume a ring by the same rules.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "motion/step_ring.h" // struct step_ring

enum step_engine_state {
    STEP_ENGINE_IDLE = 0,    // no line; an empty ring means another idle period
    STEP_ENGINE_IN_LINE = 1, // an empty ring means: too late, halt
    STEP_ENGINE_HALTED =
        2, // ran empty inside a line, or was stopped: the ring is not read any more
    STEP_ENGINE_HALTING = 3, // the same, but the period that the timer holds still comes
};

// In a line, or not quite out of it.
static inline bool step_engine_going(enum step_engine_state state)
{
    return ((uint8_t)state & 1u) != 0;
}

// Offsets up to the runs are known to the assembly handler.
struct step_engine {
    volatile uint8_t tail;        // next slot to read; written by the interrupt only
    volatile uint8_t state;       // enum step_engine_state
    volatile uint16_t idle_count; // idle periods loaded so far (wraps)
    volatile int8_t left; // periods of a run still to load: > 0 of run 0, < 0 of run 1
    volatile uint8_t run_high; // top_high of that run
    struct step_run runs[STEP_RUNS];
    volatile int8_t
        cut;       // like left: taken away from the end of a run, never to be loaded
    bool pulse;    // periods pulse now
    bool negative; // direction output
};

// One period to hand to the timer.
struct step_load {
    uint16_t top_ticks; // length - 1
    bool pulse;         // false: no STEP edge in this period
    bool turned;        // the direction output must be set to engine->negative now
};

// What the interrupt has done so far, sampled together.
struct engine_sample {
    uint8_t tail;
    uint8_t left; // periods of the run before `tail` that are not loaded yet
    bool cut;     //   and never will be
    uint8_t run;  //   which run, while some are left
    uint16_t idle_count;
};

void step_engine_reset(struct step_engine *engine, struct step_ring *ring);

// Take the next period from the ring. Called in the step interrupt (or natively).
struct step_load step_engine_next(struct step_engine *engine,
                                  const struct step_ring *ring);

// A new beginning after a halt: the slot at which the writer goes
// on. With the step interrupt off.
uint8_t step_engine_settle(struct step_engine *engine, struct step_ring *ring);

// Of an engine that was halted inside step_engine_next(): the rest of the run that it took then.
static inline void step_engine_cut(struct step_engine *engine)
{
    if (engine->state == STEP_ENGINE_HALTING && engine->left != 0) {
        engine->cut = engine->left;
        engine->left = 0;
    }
}

// Nothing more of what stands in the ring, the rest of a run included. True out of a line: then the
// ring is not looked at any more, whatever the writer does. With the step interrupt off, and short
// for that reason.
//
// taking: the step interrupt is in the middle of step_engine_next(). What it has begun to take
// counts as taken and is not touched, step_engine_cut() follows; a line just being begun goes on.
static inline bool step_engine_halt(struct step_engine *engine,
                                    struct step_ring *ring,
                                    bool taking)
{
    int8_t left = engine->left;

    if (!taking) {
        ring->high[engine->tail] = STEP_HIGH_EMPTY;
    }
    if (left != 0) {
        engine->cut = left;
        engine->left = 0;
    }
    if (engine->state != STEP_ENGINE_IN_LINE) {
        return false;
    }
    engine->state = STEP_ENGINE_HALTING;
    return true;
}

static inline uint8_t step_engine_size(int8_t left)
{
    return (uint8_t)(left < 0 ? -left : left);
}

// From engine fields that were read together, with the step interrupt off.
static inline struct engine_sample step_engine_sample_of(uint8_t tail,
                                                         int8_t left,
                                                         int8_t cut,
                                                         uint16_t idle_count)
{
    return (struct engine_sample){
        .tail = tail,
        .left = step_engine_size(cut != 0 ? cut : left),
        .cut = cut != 0,
        .run = left < 0,
        .idle_count = idle_count,
    };
}

static inline struct engine_sample step_engine_sample(const struct step_engine *engine)
{
    return step_engine_sample_of(
        engine->tail, engine->left, engine->cut, engine->idle_count);
}
