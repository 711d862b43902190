// SPDX-License-Identifier: MIT
// Time according to the step interrupts against an independent clock. An overflow that is late by a
// whole period leaves no trace in the one flag that announces it, but from then on the axis's
// account of time lags behind: by the shortest interval at least, which timer 0 can tell. So even a
// step interrupt that was kept waiting beyond every budget ends in a named fault.
#pragma once

#include <stdbool.h>
#include <stdint.h>

// Start the step timers, and time with them.
void time_check_start(void);

// One running axis every few milliseconds. Main loop only.
void time_check_poll(void);

// This axis's account of time has fallen behind.
bool time_check_lags(uint8_t axis);
