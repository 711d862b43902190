// SPDX-License-Identifier: MIT
// Parked axes: at rest, no step interrupt serves them, and their idle periods are counted by the
// coarse clock. A board with a single axis parks nothing. Main loop only.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "avr/hal/step_isr.h" // step_engines
#include "config.h"           // CONFIG_AXES

// Also with interrupts off.
static inline bool step_is_parked(uint8_t axis)
{
    return CONFIG_AXES > 1 &&
           step_engines[CONFIG_INDEX(axis)].state == STEP_ENGINE_PARKED;
}

// The work of step_timer_park(). A halt that came while nothing served the axis is only noted: it
// is the caller's to do.
bool step_park(uint8_t axis, uint16_t idle_count);

// The work of step_timer_unpark(), of a parked axis for which no halt is noted. The same holds for
// a halt that comes meanwhile.
void step_unpark(uint8_t axis);

// Idle periods of a parked axis up to now.
uint16_t step_parked_idle_count(uint8_t axis);

// Idle periods of a parked axis at an edge that its timer captured, when a little later the coarse
// clock's low 16 bits were `units`. Before the axis is parked anew.
uint16_t step_parked_idle_count_at(uint8_t axis, uint16_t units, uint16_t captured);
