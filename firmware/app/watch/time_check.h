// SPDX-License-Identifier: MIT
// Compares time according to the step interrupts with an independent clock. An overflow that is
// late by a whole period leaves no trace in the one flag that announces it, but afterwards the
// axis's account of time lags by the shortest interval at least, and timer 0 can measure that. So
// even a step interrupt that was delayed beyond every budget ends in a named fault. Main loop only.
#pragma once

#include <stdbool.h>
#include <stdint.h>

// Start the step timers and the measurement of time.
void time_check_start(void);

// Check one axis every few milliseconds. An axis at rest, too: what its step interrupts missed as
// it came to rest, or since, would be missing in its position and in the place of its next line.
void time_check_poll(void);

// Check this axis now, before it counts as done, stopped or parked. Returns false when its account
// of time has fallen behind; the fault is then latched.
bool time_check_passes(uint8_t axis);

// The time by the coarse clock, ticks since the timers started, rounded down; wraps. Where an axis
// has an account of its own, that is exact.
uint32_t time_check_now_ticks(void);

// True when this axis's account of time has fallen behind; brings its ledger up to date before.
bool time_check_lags(uint8_t axis);
