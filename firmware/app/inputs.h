// SPDX-License-Identifier: MIT
// Home and limit switches, filtered: a change counts when it has lasted settings.input_filter_us.
// Main loop only.
#pragma once

#include <stdbool.h>
#include <stdint.h>

// One axis's look at its switches. Bits as in hal/switches.h, set for closed or tripped.
struct inputs {
    uint8_t state;      // filtered
    uint8_t seen;       // at the last look
    uint16_t since_4us; // when that changed, low 16 bits
    uint16_t position;  // low 16 bits, at the last look with a limit tripped
};

// One look at an axis's switches; a limit that is passed latches a fault.
void inputs_poll(uint8_t axis);

// The home switch is closed, and was for as long as the filter asks for; or is open.
bool inputs_home_closed(uint8_t axis);

// Nothing has changed for so long.
bool inputs_settled(uint8_t axis);

// Filtered switches of all axes, four bits each.
uint16_t inputs_all(void);
