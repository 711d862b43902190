// SPDX-License-Identifier: MIT
// The check of what stands in front of a line's segments (line_check.h):
//
//     start mark          flags that fit each other; the line before it counts only if this one may
//                         follow it without a pause
//     parameter           backlash, and the speed at which it is taken up
//     divider, if the     clock edges a pixel: those that the limits are of
//     mark promises one
#pragma once

#include "base/names.h"            // enum line_error
#include "line/line_check_state.h" // struct line_check
#include "line/segment.h"          // struct segment

// For line_check.c alone, except for line_check_reset(). Main loop, and the host tools.

// Expect the start of a line that follows no other: any direction may come first. Everything that
// the check knew is forgotten, the fastest speeds included.
void line_check_reset(struct line_check *check);

// Accept the next entry in front of the segments and return LINE_none, or return why the entry is
// not possible. Only while check->phase is not LINE_CHECK_SEGMENTS. A parameter and a divider cost
// a division.
enum line_error line_check_head(struct line_check *check,
                                const struct line_limits *limits,
                                struct segment entry);
