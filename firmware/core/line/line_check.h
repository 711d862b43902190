// SPDX-License-Identifier: MIT
// Checks whether the board can run a line. The check gets the entries one by one as they arrive, so
// that a line longer than the memory is checked too. An entry is queued only after it was accepted:
// of a line that is armed before its end has come, no entry after a refused one reaches the
// decoder. axis_queue_block() runs the check on a copy, in the main loop; the host tools run the
// same code.
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

// From here on these limits count, which may differ from the limits of the entries before. To be
// called before the entries of each block. Divides.
void line_check_limits(struct line_check *check, const struct line_limits *limits);

// Accept the next entry and return LINE_none, or return why the entry is not possible. The reason
// concerns the pixel after check->pixel. After a refusal the state of the check means nothing: the
// caller drops the copy, or resets the check.
//
// The limits must be those of line_check_limits(). An entry that goes on as the line does, slowly
// enough, needs no closer look and costs a small part of what others cost.
enum line_error line_check_entry(struct line_check *check,
                                 const struct line_limits *limits,
                                 struct segment entry);

#if SEVERAL_AXES
// Pass the packed entries from reader->at on that are one or two bytes long and need no closer
// look, up to the first other entry or to the byte `size` of reader->bytes: most pixels of a plain
// line, at a third of the cost. Outside a line's segments, and in a smooth line, nothing happens.
void line_check_pass_easy(struct line_check *check,
                          struct segment_reader *reader,
                          uint8_t size);
#endif
