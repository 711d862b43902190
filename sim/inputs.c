// SPDX-License-Identifier: MIT

#include "inputs.h"

#define COMPARATOR_TIMER '1' // the only timer that can capture the comparator's output

// The comparator takes the place of the timer's pin.
static bool captures_comparator(const struct inputs *in, int timer)
{
    return in->timers->timer[timer].name == COMPARATOR_TIMER &&
           comparator_captures(in->comparator);
}

void inputs_follow_port(struct inputs *in, unsigned port, uint64_t cycle)
{
    struct timers *t = in->timers;
    char name = (char)('A' + port);

    for (int i = 0; i < t->count; i++) {
        if (t->icp[i].port == name && !captures_comparator(in, i)) {
            timer16_icp(&t->timer[i], ports_level(in->ports, name, t->icp[i].bit), cycle);
        }
    }
    comparator_follow(in->comparator, name, cycle);
    extint_follow(in->extint, name, cycle);
}

void inputs_follow_comparator(struct inputs *in, uint64_t cycle)
{
    struct timers *t = in->timers;

    for (int i = 0; i < t->count; i++) {
        if (t->timer[i].name == COMPARATOR_TIMER) {
            bool level = captures_comparator(in, i)
                             ? in->comparator->output
                             : ports_level(in->ports, t->icp[i].port, t->icp[i].bit);

            timer16_icp(&t->timer[i], level, cycle);
        }
    }
}

void inputs_drive(struct inputs *in, char port, unsigned bit, bool level, uint64_t cycle)
{
    if (!ports_has(in->ports, port, bit)) {
        return;
    }
    if (in->wire_log != NULL && !ports_is_driven(in->ports, port, bit, level)) {
        wire_log_pin(in->wire_log, port, bit, level, cycle);
    }
    ports_drive(in->ports, port, bit, level, cycle);
    switches_pin_driven(in->switches, port, bit, level, cycle);
    inputs_follow_port(in, (unsigned)(port - 'A'), cycle);
}
