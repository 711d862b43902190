// SPDX-License-Identifier: MIT
// The permit output, the gate of a laser or a spindle. Main loop only; the interrupt of the
// emergency stop switches the output off by itself (hal/estop.h).
//
//     permit_is_on()    ___/~~~~~~~~~~~\___________   off when the main loop latches the fault
//     emergency stop    ____________/~~~~~~~~~\_____
//     PERMIT output     ___/~~~~~~~~\______________   off at once, by the stop's interrupt
#pragma once

#include <stdbool.h>

// Switch the permit on or off. The output follows at once, unless an emergency stop holds it off.
void permit_set(bool on);
// True when the permit was switched on and not off since; an emergency stop may hold the output off
// all the same.
bool permit_is_on(void);
