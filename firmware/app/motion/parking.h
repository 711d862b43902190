// SPDX-License-Identifier: MIT
// Parks axes at rest, so that their idle periods cost no interrupt: every interrupt of an axis at
// rest would keep the step interrupts of those that move waiting. Only on a board of several axes.
// An axis is unparked where its line is released (start.c) or its seek begins (seek.c).
//
//     RUNNING --> DONE ... two idle periods later --> parked --> STARTING, released: unparked
#pragma once

// Park an axis that has come to rest. Looks at one axis after the other; once a round.
void parking_poll(void);
