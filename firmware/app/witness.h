// SPDX-License-Identifier: MIT
// Sees motion that nobody asked for: STEP edges of an axis at rest, told by the flag that the
// edge's own match sets in the timer, whatever the software believes of engine, ring and registers.
// Such an edge is a fault within a round of the main loop, and no other follows.
#pragma once

#include <stdint.h>

// The axis begins to run: its edges are asked for, and the first looks behind its last one too.
void witness_excuse(uint8_t i);

// In every round of the main loop, unless the axis runs.
void witness_poll(uint8_t i);
