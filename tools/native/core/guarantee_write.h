// SPDX-License-Identifier: MIT
// What the decoder may write for an axis now, and whether it is there in time.
#pragma once

#include <stdbool.h>

#include "guarantee_loop.h" // struct loop

#define MARKS 15u // that may be written ahead

// True when the next part must wait for edges of the clock.
bool loop_is_early(const struct loop *r, const struct axis *a);

// True when the next part of an axis may be written now, in a new call of the decoder.
bool loop_may_write(const struct loop *r, struct axis *a);

// The same in the call that has written the part before, if `goes_on`.
bool loop_may_write_more(const struct loop *r, struct axis *a, bool goes_on);

// Write the next part. Only when it may be written.
void loop_write_part(struct loop *r, struct axis *a);
