// SPDX-License-Identifier: MIT
// The emergency stop input, and the permit output that depends on it. An edge of the input is an
// interrupt. When the input then stays tripped for about 10 us (a shorter pulse is noise), the
// interrupt halts every axis and switches the permit off, whatever the main loop does.
//
//     input   ____/~~~~~~~~~~~~~~~~~~~~~~~~~
//                 |-- 10 us --|
//     permit  ~~~~~~~~~~~~~~~~\_____________   off until the main loop permits again
//     timers  the period that each timer holds, then idle periods: no further STEP edge
#pragma once

#include <stdbool.h>

// Enable the interrupt. tripped_high: the input is tripped when its pin is high, else when its pin
// is low.
void estop_start(bool tripped_high);

// Called in every round of the main loop: an input that stays tripped without an edge counts too.
void estop_poll(bool tripped_high);

// The input is tripped now.
bool estop_tripped(void);
// The input was tripped since estop_release().
bool estop_latched(void);
// Forget the latched stop. The main loop clears a fault.
void estop_release(void);

// Switch the permit output; a latched stop keeps it off.
void permit_write(bool on);
