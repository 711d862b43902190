// SPDX-License-Identifier: MIT
// What the board and its settings allow a line to be. Main loop only.
//
//     settings (registers.def) --+
//                                +--> struct line_limits --> check of every queued block
//     board file (config.h) -----+--> feed.reversal_ticks of each axis
#pragma once

#include "line/line_check.h" // struct line_limits

// Compute the pixel period, the limits and the reversal time of each axis from the settings. Called
// at start and after each change of the settings, while no segment is queued: queued segments were
// checked against the old limits. No line is the reference afterwards.
void limits_apply_settings(void);

// Compute the same for the check of one line alone: the clock goes on being measured as before. The
// trial must end: by this function again, after the caller has restored the settings, or by
// limits_apply_settings().
void limits_try_settings(void);

// The limits of a line that is queued for this axis, times in ticks. For an axis that is neither
// armed nor running: the limits of an axis alone, since only arming tells which axes move together.
// Else the limits of all axes that are armed or running. Valid until the next call.
const struct line_limits *limits_of(uint8_t axis);
// The limits of `axes` axes that move together; of none as of one. Valid until the next call of
// either function.
const struct line_limits *limits_together(uint8_t axes);
