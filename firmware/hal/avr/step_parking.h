// SPDX-License-Identifier: MIT
// What the account and the captures must know of parked axes.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "config.h"           // CONFIG_AXES
#include "hal/avr/step_isr.h" // step_engines

// True while no interrupt serves the axis. A single axis is never parked.
static inline bool step_parking_parked(uint8_t axis)
{
    return CONFIG_AXES > 1 && step_engines[axis].state == STEP_ENGINE_PARKED;
}

#if CONFIG_AXES > 1
// Idle periods of a parked axis by now.
uint16_t step_parking_idle_count(uint8_t axis);

// The same at an edge that the axis's timer captured, when a little later the coarse clock's low 16
// bits were `units`. Main loop only, before the axis is parked anew.
uint16_t step_parking_idle_count_at(uint8_t axis, uint16_t units, uint16_t captured);
#endif
