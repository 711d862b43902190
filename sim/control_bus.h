// SPDX-License-Identifier: MIT
//
// The control protocol's commands for the serial bus and its master (control.h describes them).
#pragma once

#include "control_words.h"

// Ended by a command without a name.
extern const struct command control_bus_commands[];
