// SPDX-License-Identifier: MIT
#include "motion/step_engine.h"

void step_engine_reset(struct step_engine *engine, struct step_ring *ring)
{
    engine->tail = 0;
    engine->state = STEP_ENGINE_IDLE;
    engine->idle_count = 0;
    engine->pulse = false;
    engine->negative = false;
    ring->high[0] = STEP_HIGH_EMPTY;
}

static struct step_load idle_load(struct step_engine *engine, bool turned)
{
    engine->pulse = false;
    engine->idle_count = (uint16_t)(engine->idle_count + 1u);
    return (struct step_load){
        .top_ticks = STEP_IDLE_TICKS - 1u, .pulse = false, .turned = turned};
}

struct step_load step_engine_next(struct step_engine *engine,
                                  const struct step_ring *ring)
{
    bool turned = false;

    // What the writer adds after a halt must never be taken for a part of the line.
    if (engine->state == STEP_ENGINE_HALTED) {
        return idle_load(engine, turned);
    }
    for (;;) {
        uint8_t tail = engine->tail;
        uint8_t high = ring->high[tail];
        uint8_t low = ring->low[tail];

        if (high == STEP_HIGH_EMPTY) {
            if (engine->state == STEP_ENGINE_IN_LINE) {
                engine->state = STEP_ENGINE_HALTED;
            }
            return idle_load(engine, turned);
        }
        engine->tail = (uint8_t)(tail + 1u);
        if (high != STEP_HIGH_COMMAND) {
            return (struct step_load){
                .top_ticks = (uint16_t)(((uint16_t)high << 8) | low),
                .pulse = engine->pulse,
                .turned = turned,
            };
        }
        if (low <= STEP_COMMAND_PULSE) {
            engine->pulse = low == STEP_COMMAND_PULSE;
        } else if (low >= STEP_COMMAND_POSITIVE) {
            engine->negative = low == STEP_COMMAND_NEGATIVE;
            turned = true;
        } else if (low == STEP_COMMAND_BEGIN) {
            engine->state = STEP_ENGINE_IN_LINE;
        } else {
            engine->state = STEP_ENGINE_IDLE;
            return idle_load(engine, turned);
        }
    }
}
