// SPDX-License-Identifier: MIT
// What stops the machine whatever it does: the emergency stop, a silent bus, a stack that grew too
// far; and the watchdog, which is fed only while everything is alive. Main loop only.
#pragma once

#include <stdbool.h>

// After machine_init(): begins to watch, and latches the fault of a reset that nobody asked for.
void safety_start(void);

void safety_poll(void);

// Faults may be cleared: the emergency stop is released, the stack is sound.
bool safety_allows(void);
