// SPDX-License-Identifier: MIT
// What the board and its settings allow a line to be. Main loop only.
#pragma once

#include "motion/line_check.h" // struct line_limits

// After a change of the settings: the pixel period, the limits, and what they mean for each axis.
void limits_apply_settings(void);

const struct line_limits *limits_now(void);
