// SPDX-License-Identifier: MIT
// Sees motion that nobody asked for: STEP edges of an axis at rest, told by the flag that the edge's
// own match sets in the timer. Whatever the software believes of engine, ring and registers, an
// unasked edge is a fault within a round of the second period, and the pin is taken from the timer.
#pragma once

#include <stdint.h>

// In every round of the main loop.
void witness_poll(uint8_t axis);
