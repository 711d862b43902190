// SPDX-License-Identifier: MIT
//
// The control protocol's commands for one board: its memories, pins, supply, resets and faults
// (control.h describes them).
#pragma once

#include "control_words.h"

// Ended by a command without a name.
extern const struct command control_board_commands[];
