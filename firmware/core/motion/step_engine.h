// SPDX-License-Identifier: MIT
// What the step interrupt does, in C. On the AVR an assembly handler does the frequent case (a
// plain period) and calls step_engine_next() for the rest; natively the planner and the tests call
// it for everything, so both consume a ring by the same rules.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "motion/step_codes.h" // STEP_STATE_*
#include "motion/step_ring.h"  // struct step_ring

enum step_engine_state {
    // No line: an empty ring means another idle period.
    STEP_ENGINE_IDLE = STEP_STATE_IDLE,
    // An empty ring means: too late, halt.
    STEP_ENGINE_IN_LINE = STEP_STATE_IN_LINE,
    // The ring is not read; the timer makes idle periods.
    STEP_ENGINE_HALTED = STEP_STATE_HALTED,
    // The same, but the period that the timer holds still comes.
    STEP_ENGINE_HALTING = STEP_STATE_HALTING,
};

//            BEGIN               END
//     IDLE ---------> IN_LINE ---------> IDLE
//       |               |   |
//       | halt     halt |   +----------------+ empty ring
//       |               v                    v
//       +-----------> HALTING ------------> HALTED ---------> IDLE
//                              next period           settle
//
// halt, again and in any state, changes nothing that a halt has done; settle is refused while the
// engine is going.

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
    volatile uint8_t train_high; // top_high of that run
    struct pulse_train trains[STEP_TRAINS];
    volatile bool stop; // halted, or to be: nothing more is taken from the ring
    bool pulse;         // periods pulse now
    volatile int8_t
        cut;       // like left: taken away from the end of a run, never to be loaded
    bool negative; // direction output
};

// One period to hand to the timer.
struct step_load {
    uint16_t top_ticks; // length - 1
    bool pulse : 1;     // false: no STEP edge in this period
    bool idle : 1;      // to be counted: step_engine_count()
    bool reverses;      // the direction output must be set to engine->negative now
};

// What the interrupt has done so far, sampled together.
struct engine_sample {
    uint8_t tail;
    uint8_t left;  // periods of the run before `tail` that are not loaded yet
    bool cut;      //   and never will be
    uint8_t train; //   which run, while some are left
    uint16_t idle_count;
};

void step_engine_reset(struct step_engine *engine, struct step_ring *ring);

// Take the next period from the ring. Called in the step interrupt, with interrupts on.
struct step_load step_engine_take(struct step_engine *engine,
                                  const struct step_ring *ring);

// Count it, if it is an idle one. With interrupts off: a capture reads both bytes of the count.
static inline void step_engine_count(struct step_engine *engine,
                                     const struct step_load *load)
{
    if (load->idle) {
        engine->idle_count = (uint16_t)(engine->idle_count + 1u);
    }
}

// Both, where nothing can come between.
static inline struct step_load step_engine_next(struct step_engine *engine,
                                                const struct step_ring *ring)
{
    struct step_load load = step_engine_take(engine, ring);

    step_engine_count(engine, &load);
    return load;
}

// A new beginning after a halt. False, and nothing done, while the engine is going: the timer still
// holds a period that pulses. *slot: where the writer continues. With the step interrupt off.
bool step_engine_settle(struct step_engine *engine,
                        struct step_ring *ring,
                        uint8_t *slot);

// Nothing more of what stands in the ring is taken, the rest of a run included, whatever the writer
// does. The timer makes the period that it holds, then idle ones. In every state and however often;
// with the step interrupt off, and short for that reason.
static inline void step_engine_halt(struct step_engine *engine)
{
    int8_t left = engine->left;

    engine->stop = true;
    if (left != 0) {
        engine->cut = left;
        engine->left = 0;
    }
    if (engine->state != STEP_ENGINE_HALTED) {
        engine->state = STEP_ENGINE_HALTING;
    }
}

// The same while the step interrupt is in the middle of step_engine_next(): what it has begun to
// take counts as taken, and step_engine_halt() follows when it is done.
static inline void step_engine_halt_soon(struct step_engine *engine)
{
    engine->stop = true;
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
        .train = left < 0,
        .idle_count = idle_count,
    };
}

static inline struct engine_sample step_engine_sample(const struct step_engine *engine)
{
    return step_engine_sample_of(
        engine->tail, engine->left, engine->cut, engine->idle_count);
}
