// SPDX-License-Identifier: MIT
// What the board and its settings allow a line to be. Main loop only.
//
//     settings (registers.def) --+
//                                +--> struct line_limits --> check of every queued block
//     board file (config.h) -----+--> feed.reversal_ticks of each axis
#pragma once

#include "motion/line_check.h" // struct line_limits

// Compute the pixel period, the limits and the reversal time of each axis from the settings. Called
// at start and after each change of the settings, while no line is queued: queued lines were
// checked against the old limits. No line is the reference afterwards.
void limits_apply_settings(void);

// The limits that queued lines are checked against, times in ticks. Valid until the next change of
// the settings.
const struct line_limits *limits_now(void);
