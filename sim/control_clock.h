// SPDX-License-Identifier: MIT
//
// The control protocol's commands for the pixel clock and each board's pin of it (control.h
// describes them).
#pragma once

#include "control_words.h"

// Ended by a command without a name.
extern const struct command control_clock_commands[];
