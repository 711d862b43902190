// SPDX-License-Identifier: MIT
// Checks whether the board can run a line. The check gets the segments one by one as they arrive,
// so that a line longer than the memory is checked too. A line may be armed only when its end mark
// was accepted. Of a streamed line no segment after a refused one reaches the decoder.
// The host tools run the same code.
//
//     OUTSIDE -- start mark --> PARAMETER -- parameter --> SEGMENTS -- end mark --> OUTSIDE
//                                    |                     ^ |  ^ segment, down mark
//                          parameter |                     | +--+
//                                    +-------> DIVIDER ----+ divider
#pragma once

#include "base/names.h"            // enum line_error
#include "build_features.h"        // SEVERAL_AXES
#include "line/line_check_head.h"  // line_check_reset
#include "line/line_check_state.h" // struct line_check, struct line_limits
#include "line/segment.h"          // struct segment
#include "line/segment_pack.h"     // struct segment_reader

// The limits may be others than those of the entries before. Divides.
void line_check_limits(struct line_check *check, const struct line_limits *limits);

// Accept the next entry, or return why not; the reason concerns the pixel behind check->pixel.
// After a refusal the check must be reset.
enum line_error line_check_entry(struct line_check *check,
                                 const struct line_limits *limits,
                                 struct segment entry);

#if SEVERAL_AXES
// Pass those of the packed entries in front of `size` that are one or two bytes long and need no
// closer look, up to the first other one: most pixels of a plain line, at a third of the cost.
void line_check_pass_easy(struct line_check *check,
                          struct segment_reader *reader,
                          uint8_t size);
#endif
