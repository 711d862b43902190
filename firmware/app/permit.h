// SPDX-License-Identifier: MIT
// The permit output, the gate of a laser or a spindle. Main loop only; the interrupt of the
// emergency stop switches the output off by itself (hal/estop.h).
#pragma once

#include <stdbool.h>

// Switch the permit on or off.
void permit_set(bool on);
// The permit was switched on and not off since; an emergency stop may hold the output off.
bool permit_is_on(void);
