// SPDX-License-Identifier: MIT
// Detects motion that nobody requested: STEP edges of an axis at rest. The timer's own match sets a
// flag at each edge, whatever the software's state of engine, ring and registers is. Such an edge
// latches a fault within a round of the main loop, and no further edge follows. Main loop only.
//
//     STEP         ____/~\____________________________/~\____
//     axis runs    ~~~~~~~~\_________________________________
//     rounds                | 1 | 2 | 3 | 4 | ...      ^ stray: output silenced, fault latched
//                           |-------| not judged: the last edge of the line may still come
//
// `i` is the axis, 0..CONFIG_AXES-1.
#pragma once

#include <stdint.h>

// The axis begins to run, and its edges are requested.
void witness_excuse(uint8_t i);

// Check the axis's flag. In every round of the main loop, unless the axis runs.
void witness_poll(uint8_t i);
