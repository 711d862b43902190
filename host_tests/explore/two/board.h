// SPDX-License-Identifier: MIT
// What board.h says of the one axis, of each of two.
#pragma once

#include <stdbool.h>
#include <stdint.h>

bool two_held(uint8_t axis);     // armed, not released
bool two_moving(uint8_t axis);   // armed or running
bool two_finished(uint8_t axis); // the last line came to its end
bool two_loaded(uint8_t axis);   // the next line waits to be armed
bool two_empty(uint8_t axis);    // no line is queued
bool two_halted(uint8_t axis);   // the engine loads no periods of a line any more
bool two_rests(uint8_t axis);    // nothing changes any more without an order
int32_t two_position(uint8_t axis);
