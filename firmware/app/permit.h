// SPDX-License-Identifier: MIT
// The permit output: the gate of a laser or a spindle. Main loop only; the emergency stop's
// interrupt takes the output away by itself (hal/estop.h).
#pragma once

#include <stdbool.h>

void permit_set(bool on);
bool permit_is_on(void);
