// SPDX-License-Identifier: MIT
// The emergency stop input and the permit output that it takes away. An edge of the input is an
// interrupt: when the input then stays tripped for about 10 us (a shorter pulse is noise), every
// axis is halted and the permit is off, whatever the main loop does. Each timer still makes the
// period that it holds: no STEP edge after that one.
#pragma once

#include <stdbool.h>

// tripped_high: the input is tripped when its pin is high, else when it is low.
void estop_start(bool tripped_high);

// In every round of the main loop: what stays tripped counts without an edge too.
void estop_poll(bool tripped_high);

bool estop_tripped(void); // now
bool estop_latched(void); // since estop_release()
void estop_release(void);

void permit_write(bool on);
