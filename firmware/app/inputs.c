// SPDX-License-Identifier: MIT
#include "app/inputs.h"

#include "app/machine.h"  // machine
#include "hal/clock.h"    // clock_now_4us
#include "hal/switches.h" // switches_read

#define US_PER_UNIT 4u
#define LIMITS      (SWITCH_LIMIT_MINUS | SWITCH_LIMIT_PLUS)

static uint8_t tripped_levels(void)
{
    uint8_t inverted = (uint8_t)machine.settings.inputs_inverted;
    uint8_t home = (inverted & 1u) != 0 ? SWITCH_HOME : 0;
    uint8_t limits = (inverted & 2u) != 0 ? LIMITS : 0;

    return (uint8_t)(home | limits);
}

static bool lasted(const struct inputs *inputs)
{
    uint16_t since_4us = (uint16_t)((uint16_t)clock_now_4us() - inputs->since_4us);

    return since_4us > machine.settings.input_filter_us / US_PER_UNIT;
}

// True when the filtered state has just changed.
static bool filter(struct inputs *inputs, uint8_t now)
{
    if (now != inputs->seen) {
        inputs->seen = now;
        inputs->since_4us = (uint16_t)clock_now_4us();
    } else if (now != inputs->state && lasted(inputs)) {
        inputs->state = now;
        return true;
    }
    return false;
}

// A limit stops what moves on towards it; what moves away from it, or stands there, may.
static void watch_limits(uint8_t i, bool first_look)
{
    struct axis *axis = machine_axis(i);
    struct inputs *inputs = machine_inputs(i);

    if (axis->state != AXIS_RUNNING && !first_look) {
        return;
    }
    (void)machine_follow(i);
    uint16_t position = (uint16_t)ledger_position(&axis->ledger);
    int16_t moved = first_look ? 0 : (int16_t)(position - inputs->position);

    inputs->position = position;
    if (moved > 0 && (inputs->state & SWITCH_LIMIT_PLUS) != 0) {
        machine_fault(FAULT_limit_plus, i, 0);
    } else if (moved < 0 && (inputs->state & SWITCH_LIMIT_MINUS) != 0) {
        machine_fault(FAULT_limit_minus, i, 0);
    }
}

void inputs_poll(uint8_t axis)
{
    struct inputs *inputs = machine_inputs(axis);
    uint8_t now = (uint8_t)((switches_read(axis) ^ tripped_levels()) ^ SWITCH_ALL);
    bool changed = filter(inputs, now);

    if ((inputs->state & LIMITS) != 0) {
        watch_limits(axis, changed);
    }
}

bool inputs_home_closed(uint8_t axis)
{
    return (machine_inputs(axis)->state & SWITCH_HOME) != 0;
}

bool inputs_settled(uint8_t axis)
{
    const struct inputs *inputs = machine_inputs(axis);

    return inputs->seen == inputs->state && lasted(inputs);
}

uint16_t inputs_all(void)
{
    uint16_t all = 0;

    for (uint8_t i = CONFIG_AXES; i-- != 0;) {
        all = (uint16_t)(all << 4 | machine_inputs(i)->state);
    }
    return all;
}
