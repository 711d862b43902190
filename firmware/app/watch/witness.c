// SPDX-License-Identifier: MIT
#include "app/watch/witness.h"

#include "app/axes/faults.h" // faults_latch_stray
#include "config.h"          // CONFIG_AXES
#include "hal/step_timer.h"  // step_timer_*

// The last edge of a line may come up to STEP_TIMER_EDGE_TICKS after the axis is first seen at
// rest. An edge is therefore a stray step only from the second look at rest on, one round later.
#define LOOKS_BEFORE 2u

static uint8_t looks_at_rest[CONFIG_AXES];

void witness_excuse(uint8_t i)
{
    looks_at_rest[CONFIG_INDEX(i)] = 0;
}

void witness_poll(uint8_t i)
{
    uint8_t *looks = &looks_at_rest[CONFIG_INDEX(i)];

    // The first look at rest clears the flag that the running axis has left set.
    bool pulsed = step_timer_pulsed(i);

    if (step_timer_state(i) == STEP_ENGINE_HALTING) {
        *looks = 0;
    } else if (*looks != LOOKS_BEFORE) {
        (*looks)++;
    } else if (pulsed) {
        step_timer_silence(i);
        faults_latch_stray(i);
    }
}
