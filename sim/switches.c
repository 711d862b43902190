// SPDX-License-Identifier: MIT

#include "switches.h"

#include <inttypes.h>

static const enum board_signal signals[PLANT_SWITCHES] = {
    [PLANT_HOME] = SIGNAL_HOME,
    [PLANT_LIMIT_MINUS] = SIGNAL_LIMIT_MINUS,
    [PLANT_LIMIT_PLUS] = SIGNAL_LIMIT_PLUS,
};

const struct board_pin *switches_pin(const struct switches *s,
                                     unsigned axis,
                                     enum plant_switch which)
{
    return board_kind_pin(s->kind, signals[which], axis);
}

void switches_init(struct switches *s,
                   const struct board_kind *kind,
                   int board,
                   const struct own_time *time)
{
    s->kind = kind;
    s->board = board;
    s->time = time;
    for (unsigned i = 0; i < (unsigned)kind->axes * PLANT_SWITCHES; i++) {
        const struct board_pin *pin =
            switches_pin(s, i / PLANT_SWITCHES, (enum plant_switch)(i % PLANT_SWITCHES));

        if (pin != NULL) {
            s->on_pin[(unsigned)(pin->port - 'A')][pin->bit] = (uint8_t)(i + 1U);
        }
    }
}

static void log_change(const struct switches *s,
                       unsigned axis,
                       unsigned which,
                       uint64_t cycle)
{
    if (s->log != NULL) {
        (void)fprintf(s->log,
                      "%" PRIu64 ",%d,%u,%s,%d\n",
                      cycle,
                      s->board,
                      axis,
                      plant_switch_name((enum plant_switch)which),
                      s->state[axis][which].level);
    }
}

void switches_pin_driven(
    struct switches *s, char port, unsigned bit, bool level, uint64_t cycle)
{
    unsigned place = s->on_pin[(unsigned)(port - 'A')][bit];

    if (place != 0) {
        unsigned axis = (place - 1U) / PLANT_SWITCHES;
        unsigned which = (place - 1U) % PLANT_SWITCHES;
        struct switch_state *state = &s->state[axis][which];

        if (state->level != level) {
            state->level = level;
            state->cycle = state->first_cycle = own_time_to_bench(s->time, cycle);
            log_change(s, axis, which, state->cycle);
        }
    }
}
