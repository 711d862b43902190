// SPDX-License-Identifier: MIT
// What the main loop does for the motion, round by round: take captured edges, follow the step
// interrupts, supervise, start lines, and decode for the axis that is least buffered. Main loop
// only.
//
//     +-> underruns --> clock edge --> ledgers --> states --> safety, switches -->
//     |                      starts --> time-out of the clock --> store --> decode --+
//     +-------------------------------------------------------------------------------+
#pragma once

#include "build_features.h" // SEVERAL_AXES

// The next round begins with the first axis.
void round_start(void);

// One round: short, never waits. Call it again and again.
void round_poll(void);

#if SEVERAL_AXES
// What cannot wait for the end of a request: edges of the clock, a start that is near, and rings
// that run low. While what is decoded lasts for all axes, nothing more is done; else accounts are
// advanced, and the decoder is called for two axes at most, those that run out first.
void round_poll_briefly(void);
#endif
