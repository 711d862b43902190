// SPDX-License-Identifier: MIT
// What the main loop does for the motion, round by round: take captured edges, follow the step
// interrupts, watch, start, decode for the axis nearest to starving.
#pragma once

// The first axis is the first whose turn it is.
void round_start(void);

// One round: short, never waits. Call again and again.
void round_poll(void);
