// SPDX-License-Identifier: MIT
// The board's axes, each above its ring and its step timer: how far each has come, and how it comes
// to rest. Main loop only.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "config.h"      // CONFIG_AXES
#include "motion/axis.h" // struct axis

// No axis: an index, behind the last one.
#define NO_AXIS CONFIG_AXES

// Masks of axes: all of them, and one.
#define ALL_AXES ((uint8_t)((1u << CONFIG_AXES) - 1u))

static inline uint8_t axis_bit(uint8_t axis)
{
    return CONFIG_AXES == 1 ? 1u : (uint8_t)(1u << axis);
}

// Every axis EMPTY, at position 0. Interrupts off; time_check_start() must follow, and interrupts on
// before an idle period is over.
void axes_start(void);

// One of the axes, 0..CONFIG_AXES-1; with a single one, that one. States change by the functions of
// motion/axis.h.
struct axis *axes_get(uint8_t axis);

// Bring an axis's ledger up to what its step interrupt has done by now. False, and nothing done,
// when a captured edge must be taken first: the edge is placed by an older sample.
bool axes_follow(uint8_t axis);

// The same when that is worth the while: where the main loop can lag behind the ledger does.
void axes_follow_due(uint8_t axis);

// The same at rest, whatever waits: before the account is cut short.
void axes_account(uint8_t axis);

// Bring an axis to rest and discard every line of it, from every state and however often: at once
// when its timer makes idle periods, else the axis is STOPPING until this was called again.
void axes_stop(uint8_t axis);

uint8_t axes_first_moving(void); // the first armed or running one, NO_AXIS if none
bool axes_any_armed(void);       // with or without a place in time
bool axes_any_starting(void);
bool axes_any_queued(void); // one moves, or a line waits, whole or in part
