// SPDX-License-Identifier: MIT
// Home and limit switches, filtered: a change counts when it has lasted settings.input_filter_us.
// Main loop only.
//
//     pin      ____/~\_/~~~~~~~~~~~~~~
//                     |-- filter --|
//     filtered ____________________/~~
#pragma once

#include <stdbool.h>
#include <stdint.h>

// Every switch is open until the filter has seen otherwise.
void inputs_start(void);

// Sample one axis's switches. Latches a fault when the axis has moved on towards a tripped limit.
void inputs_poll(uint8_t axis);

// Filtered state of the axis's home switch: true when closed.
bool inputs_home_closed(uint8_t axis);

// The filter's time has passed since since_units, the low 16 bits of clock_now_units().
bool inputs_lasted(uint16_t since_units);

// The home switch is closed when its pin is high, instead of low.
bool inputs_home_inverted(void);

// The axis's home switch has not changed for the filter's time.
bool inputs_settled(uint8_t axis);

// Filtered switches of all axes, four bits each, axis 0 lowest.
uint16_t inputs_all(void);
