// SPDX-License-Identifier: MIT
#include "ring/step_engine.h"

void step_engine_reset(struct step_engine *engine, struct step_ring *ring)
{
    engine->tail = 0;
    engine->state = STEP_ENGINE_IDLE;
    engine->idle_count = 0;
    engine->left = 0;
    engine->cut = 0;
    engine->stop = false;
    engine->pulse = false;
    engine->negative = false;
    ring->high[0] = STEP_HIGH_EMPTY;
}

static struct step_load idle_load(struct step_engine *engine, bool reverses)
{
    engine->pulse = false;
    return (struct step_load){
        .top_ticks = STEP_IDLE_TICKS - 1u, .idle = true, .reverses = reverses};
}

// Take the next entry if it belongs to a pulse train. The engine looks one period ahead for such an
// entry, so that the first period of an entry takes no longer path than the others.
static void take_train_entry(struct step_engine *engine, const struct step_ring *ring)
{
    uint8_t tail = engine->tail;

    if (engine->left == 0 && ring->high[tail] == STEP_HIGH_TRAIN) {
        int8_t count = (int8_t)ring->low[tail];
        engine->left = count;
        engine->train_high = engine->trains[count < 0].top_high;
        engine->tail = (uint8_t)(tail + 1u);
    }
}

// Load the next period of a pulse train. left: periods that the entry has left, negative for the
// second train, not 0.
static struct step_load train_load(struct step_engine *engine,
                                   const struct step_ring *ring,
                                   int8_t left,
                                   bool reverses)
{
    struct pulse_train *train = &engine->trains[left < 0];
    uint16_t top_ticks = (uint16_t)((uint16_t)train->top_high << 8);

    if (train->sum >= 0) {
        top_ticks = (uint16_t)(top_ticks | train->long_low);
        train->sum = (int16_t)(train->sum + train->after_long);
    } else {
        top_ticks = (uint16_t)(top_ticks | train->short_low);
        train->sum = (int16_t)(train->sum + train->after_short);
    }
    left = (int8_t)(left < 0 ? left + 1 : left - 1);
    engine->left = left;
    take_train_entry(engine, ring);
    return (struct step_load){
        .top_ticks = top_ticks, .pulse = engine->pulse, .reverses = reverses};
}

bool step_engine_settle(struct step_engine *engine, struct step_ring *ring, uint8_t *slot)
{
    if (step_engine_going((enum step_engine_state)engine->state)) {
        return false;
    }
    *slot = engine->tail;
    ring->high[*slot] = STEP_HIGH_EMPTY;
    engine->left = 0;
    engine->cut = 0;
    engine->stop = false;
    engine->pulse = false;
    engine->state = STEP_ENGINE_IDLE;
    return true;
}

// Execute a command of the ring. Returns false when the line is over.
static bool engine_execute(struct step_engine *engine, uint8_t command, bool *reverses)
{
    if (command <= STEP_COMMAND_PULSE) {
        engine->pulse = command == STEP_COMMAND_PULSE;
    } else if (command >= STEP_COMMAND_POSITIVE) {
        engine->negative = command == STEP_COMMAND_NEGATIVE;
        *reverses = true;
    } else if (command == STEP_COMMAND_BEGIN) {
        engine->state = STEP_ENGINE_IN_LINE;
    } else {
        engine->state = STEP_ENGINE_IDLE;
        return false;
    }
    return true;
}

// The ring has nothing to take: inside a line the decoder was too late, and the engine halts.
static struct step_load take_nothing(struct step_engine *engine, bool reverses)
{
    if (engine->state == STEP_ENGINE_IN_LINE) {
        engine->stop = true;
        engine->state = STEP_ENGINE_HALTED;
    }
    return idle_load(engine, reverses);
}

struct step_load step_engine_take(struct step_engine *engine,
                                  const struct step_ring *ring)
{
    bool reverses = false;

    // A halted engine takes nothing: entries that the writer adds after a halt must never be taken
    // for a part of the line.
    if (engine->state >= STEP_ENGINE_HALTED) {
        engine->state = STEP_ENGINE_HALTED;
        return idle_load(engine, reverses);
    }
    for (;;) {
        take_train_entry(engine, ring);
        int8_t left = engine->left;
        if (left != 0) {
            return train_load(engine, ring, left, reverses);
        }
        uint8_t tail = engine->tail;
        uint8_t high = ring->high[tail];
        uint8_t low = ring->low[tail];

        if (high == STEP_HIGH_EMPTY) {
            return take_nothing(engine, reverses);
        }
        engine->tail = (uint8_t)(tail + 1u);
        if (high != STEP_HIGH_COMMAND) {
            return (struct step_load){
                .top_ticks = (uint16_t)(((uint16_t)high << 8) | low),
                .pulse = engine->pulse,
                .reverses = reverses,
            };
        }
        if (!engine_execute(engine, low, &reverses)) {
            return idle_load(engine, reverses);
        }
    }
}
