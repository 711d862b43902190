// SPDX-License-Identifier: MIT
// What the decoder may write for an axis now, and whether it is there in time.
#pragma once

#include <stdbool.h>

#include "guarantee_loop.h" // struct loop

#define MARKS 15u // that may be written ahead

// True when the next part must wait for edges of the clock.
bool loop_is_early(const struct loop *r, const struct axis *a);

// True when there is room for the next part of an axis now: in a new call of the decoder, or in the
// one that has written the part before, if it `goes_on`.
bool loop_may_begin(const struct loop *r, struct axis *a, bool goes_on);

// True when the next part must wait for a train that is free: its piece may be begun.
bool loop_awaits_train(const struct axis *a);

// True when a new call of the decoder may write the next part of an axis,
bool loop_may_write(const struct loop *r, struct axis *a);

// or begin its piece.
bool loop_may_decode(const struct loop *r, struct axis *a);

// Write the next part. Only when it may be written.
void loop_write_part(struct loop *r, struct axis *a);
