// SPDX-License-Identifier: MIT
// What the step interrupt does, in C. On the AVR an assembly handler (avr/hal/step_isr.S) does the
// frequent cases, a single period and a period of a pulse train, and calls step_engine_take() for
// the rest. The planner and the native tests call step_engine_next() for every period, so that
// board and PC consume a ring by the same rules.
//
//     ring   | taken ... | tail: next to take | ... | empty
//     timer              | running period | loaded period |     each interrupt loads one more
//
// One engine for each axis. The interrupt owns it; the main loop reads samples of it and may halt
// or settle it, as said below.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "ring/step_codes.h" // STEP_STATE_*
#include "ring/step_ring.h"  // struct step_ring

enum step_engine_state {
    // No line: an empty ring means another idle period.
    STEP_ENGINE_IDLE = STEP_STATE_IDLE,
    // In a line: an empty ring means that the decoder was too late, and halts the engine.
    STEP_ENGINE_IN_LINE = STEP_STATE_IN_LINE,
    // Halted: the ring is not read, and the timer makes idle periods.
    STEP_ENGINE_HALTED = STEP_STATE_HALTED,
    // Halted, but the timer still holds a period that may pulse.
    STEP_ENGINE_HALTING = STEP_STATE_HALTING,
    // At rest without interrupts: the timer makes idle periods that nothing counts (parked.h).
    STEP_ENGINE_PARKED = STEP_STATE_PARKED,
};

//            BEGIN               END
//     IDLE ---------> IN_LINE ---------> IDLE
//       |               |   |
//       | halt     halt |   +----------------+ empty ring
//       |               v                    v
//       +-----------> HALTING ------------> HALTED ---------> IDLE
//                              next period           settle
//
//     IDLE <--- park, unpark ---> PARKED     only by the owner of the timer (hal/step_timer.h)
//
// halt is allowed in every state; a second halt changes nothing that the first has done. settle is
// refused while the engine is going.

// True while the timer may still make a STEP edge: the engine is in a line, or it was halted and
// its last period is not over. May be called from any context.
static inline bool step_engine_going(enum step_engine_state state)
{
    return ((uint8_t)state & 1u) != 0;
}

// The state of one engine. The step interrupt writes the members; while it is off, or before it is
// enabled, step_engine_reset(), step_engine_halt() and step_engine_settle() do. The assembly
// handler knows the offsets of the members up to `cut`.
struct step_engine {
    // Slot to read next, 0..255; wraps.
    volatile uint8_t tail;
    // enum step_engine_state.
    volatile uint8_t state;
    // Idle periods loaded so far; wraps. Of a parked axis the number is older (parked.h).
    volatile uint16_t idle_count;
    // Periods of the present entry of a train that are still to be loaded, -127..127: > 0 of train
    // 0, < 0 of train 1, 0 outside a train.
    volatile int8_t left;
    // High byte of that train's intervals (top_high).
    volatile uint8_t train_high;
    // The pulse trains that the ring's entries refer to. The main loop fills a train before the
    // first entry that refers to it becomes visible.
    struct pulse_train trains[STEP_TRAINS];
    // Halted, or about to be: nothing more is taken from the ring. step_engine_halt_soon() may set
    // this member at any time; step_engine_settle() clears it.
    volatile bool stop;
    // The next period that is taken pulses.
    bool pulse;
    // Like `left`: periods at the end of an entry that a halt has cut off and that are never
    // loaded. Not 0 until step_engine_settle().
    volatile int8_t cut;
    // Level of the direction output: steps count down.
    bool negative;
};

// One period to hand to the timer.
struct step_load {
    // Length of the period minus 1, ticks, 0..STEP_PERIOD_MAX_TICKS-1.
    uint16_t top_ticks;
    // False: no STEP edge in this period.
    bool pulse : 1;
    // An idle period, to be counted by step_engine_count().
    bool idle : 1;
    // The direction output must be set to engine->negative now.
    bool reverses;
};

// What the interrupt has done so far, all read at the same instant. The main loop takes samples and
// hands them to the account (ledger.h).
struct engine_sample {
    // Slot to read next: every entry before it has been taken.
    uint8_t tail;
    // Periods of the train's entry before `tail` that are not loaded yet, 0..127.
    uint8_t left;
    // A halt has cut off the periods of `left`: they are never loaded.
    bool cut;
    // Which train, 0 or 1, while `left` is not 0.
    uint8_t train;
    // Idle periods loaded so far; wraps.
    uint16_t idle_count;
};

// A new engine, idle at slot 0 of an empty ring; direction positive. The trains stay as they are.
// To be called before the step interrupt is enabled.
void step_engine_reset(struct step_engine *engine, struct step_ring *ring);

// Take the next period from the ring and execute the commands before it. The result is an idle
// period when the ring is empty, when the line is over and when the engine is halted. An empty ring
// inside a line halts the engine: the decoder was too late, and the main loop latches the fault.
//
// Called in the step interrupt, with the other interrupts let in; each command before the period
// takes some time more. step_engine_count() must follow.
struct step_load step_engine_take(struct step_engine *engine,
                                  const struct step_ring *ring);

// Count the period if it is an idle one. Once for each period that was taken. Called with
// interrupts off, because a capture interrupt reads both bytes of the count.
static inline void step_engine_count(struct step_engine *engine,
                                     const struct step_load *load)
{
    if (load->idle) {
        engine->idle_count = (uint16_t)(engine->idle_count + 1u);
    }
}

// Take a period and count it in one call, where no interrupt can come between the two: in programs
// for the PC.
static inline struct step_load step_engine_next(struct step_engine *engine,
                                                const struct step_ring *ring)
{
    struct step_load load = step_engine_take(engine, ring);

    step_engine_count(engine, &load);
    return load;
}

// Make a halted engine IDLE at its present slot, with an empty ring. Returns false and changes
// nothing, *slot included, while the engine is going, because the timer still holds a period that
// may pulse. *slot gets the slot at which the writer must continue. Called in the main loop, with
// the step interrupt off; the counts of idle periods go on.
bool step_engine_settle(struct step_engine *engine,
                        struct step_ring *ring,
                        uint8_t *slot);

// Take nothing more from the ring, whatever the writer adds; the rest of a pulse train is cut off.
// The timer completes the period that it holds and makes idle periods afterwards. Allowed in every
// state and as often as wanted. Called with the step interrupt of the axis off, from the main loop
// or an interrupt, and short for that reason.
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

// Halt, for a caller that interrupted step_engine_take(), and for a parked axis. The period that
// the engine has begun to take counts as taken, and the interrupt calls step_engine_halt() at its
// end. One store: nothing needs to be off.
static inline void step_engine_halt_soon(struct step_engine *engine)
{
    engine->stop = true;
}

// Number of periods, 0..127, that the engine's `left` or `cut` stands for.
static inline uint8_t step_engine_size(int8_t left)
{
    return (uint8_t)(left < 0 ? -left : left);
}

// A sample from members of an engine that were read together, with the step interrupt off. The
// sample's train means nothing when nothing is left.
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

// A sample of the engine. Called with the step interrupt off, or in a program that has none.
static inline struct engine_sample step_engine_sample(const struct step_engine *engine)
{
    return step_engine_sample_of(
        engine->tail, engine->left, engine->cut, engine->idle_count);
}
