// SPDX-License-Identifier: MIT
// What the board and its settings allow a line to be. Main loop only.
#pragma once

#include "motion/line_check.h" // struct line_limits

// Called after a change of the settings: computes the pixel period, the limits and the reversal
// time of each axis.
void limits_apply_settings(void);

// The limits that queued lines are checked against.
const struct line_limits *limits_now(void);
