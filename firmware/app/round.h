// SPDX-License-Identifier: MIT
// What the main loop does for the motion, round by round: take captured edges, follow the step
// interrupts, supervise, start lines, and decode for the axis that is least buffered. Main loop
// only.
//
//     +-> underruns --> clock edge --> ledgers --> states --> safety, switches -->
//     |        starts --> time-out of the clock --> store -->|--> decode ---------+
//     |                     round_look()                     |  round_decode()    |
//     +---------------------------------------------------------------------------+
//
// Each half is short and never waits: with several axes the bus has its turn behind each of them.
#pragma once

// The next round begins with the first axis.
void round_start(void);

// Look after every axis, the clock, the inputs and the store.
void round_look(void);

// Decode steps ahead, DECODE_BUDGET at most.
void round_decode(void);

// One round as a whole. Call it again and again.
static inline void round_poll(void)
{
    round_look();
    round_decode();
}
