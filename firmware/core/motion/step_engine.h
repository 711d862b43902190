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
};

// Offsets of tail, state and idle_count are known to the assembly handler.
struct step_engine {
    volatile uint8_t tail;        // next slot to read; written by the interrupt only
    volatile uint8_t state;       // enum step_engine_state
    volatile uint16_t idle_count; // idle periods loaded so far (wraps)
    bool pulse;                   // periods pulse now
    bool negative;                // direction output
};

// One period to hand to the timer.
struct step_load {
    uint16_t top_ticks; // length - 1
    bool pulse;         // false: no STEP edge in this period
    bool turned;        // the direction output must be set to engine->negative now
};

void step_engine_reset(struct step_engine *engine, struct step_ring *ring);

// Take the next period from the ring. Called in the step interrupt (or natively).
struct step_load step_engine_next(struct step_engine *engine,
                                  const struct step_ring *ring);
