// SPDX-License-Identifier: MIT
// What stops the board whatever it does: the emergency stop, a silent bus, a stack that grew too
// far; and the watchdog, which is fed only while every step interrupt is alive. Main loop only.
//
//     main loop alive and every step interrupt alive --> watchdog fed
//     one of them hangs --> no feeding --> reset: STEP low, drivers off, permit off
#pragma once

#include <stdbool.h>

// Begin to supervise, and latch the fault of a reset that nobody requested. After board_start(),
// with interrupts on.
void safety_start(void);

// Check the emergency stop, the bus time-out and the stack, latch a fault for what is wrong, and
// feed the watchdog. Once a round.
void safety_poll(void);

// True when a fault may be cleared: the emergency stop is released, and the stack is intact.
bool safety_allows(void);
