// SPDX-License-Identifier: MIT
// Home and limit switches, filtered: a change counts when it has lasted settings.input_filter_us.
// Main loop only.
#pragma once

#include <stdbool.h>
#include <stdint.h>

// Every switch open until the filter has seen otherwise.
void inputs_start(void);

// One look at an axis's switches; a limit that is passed latches a fault.
void inputs_poll(uint8_t axis);

// The home switch is closed, and was for as long as the filter asks for; or is open.
bool inputs_home_closed(uint8_t axis);

// The filter's time has passed since then, low 16 bits in units of 4 us.
bool inputs_lasted(uint16_t since_units);

// The home switch is closed when its pin is high.
bool inputs_home_inverted(void);

// The home switch has not changed for so long.
bool inputs_settled(uint8_t axis);

// Filtered switches of all axes, four bits each.
uint16_t inputs_all(void);
