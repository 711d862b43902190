// SPDX-License-Identifier: MIT
// The check of what stands in front of a line's segments: start mark, parameter, divider.
// line_check.h explains it.
#pragma once

#include "base/names.h"              // enum line_error
#include "motion/line_check_state.h" // struct line_check
#include "motion/segment.h"          // struct segment

// Expect the start of a line that follows no other: any direction may come first.
void line_check_reset(struct line_check *check);

// Accept the next entry in front of the segments, or return why not.
enum line_error line_check_head(struct line_check *check,
                                const struct line_limits *limits,
                                struct segment entry);
