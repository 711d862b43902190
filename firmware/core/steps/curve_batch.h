// SPDX-License-Identifier: MIT
// A batch of steps of a curve: made, shown to the interrupt and noted for the account at once.
// Where several axes move, this is most of what the main loop does for a smooth line. Main loop
// only.
#pragma once

#include <stdint.h>

#include "build_features.h" // SEVERAL_AXES
#include "steps/walk.h"     // struct walk
#include "stream/stream.h"  // struct stream

// Most steps of a batch. With several axes the ledger accounts for such a batch as a whole, so that
// a batch's slots stay in use until then.
#define CURVE_BATCH (SEVERAL_AXES ? 60u : 120u)
// Most steps of a batch while the ring is nearly empty: the interrupt sees none of a batch before
// all of it is made.
#define CURVE_BATCH_LOW 16u

// The most steps of a batch, CURVE_BATCH_LOW..CURVE_BATCH, while the interrupt has `fill` entries
// left to make.
static inline uint8_t curve_batch_most(uint8_t fill)
{
    if (fill < CURVE_BATCH_LOW) {
        return CURVE_BATCH_LOW;
    }
    return fill > CURVE_BATCH ? (uint8_t)CURVE_BATCH : fill;
}

// Make `count` ordinary steps of the walk: as many as curve_narrow() has returned, as the ring has
// room for, and as walk_burst() allows. With several axes only.
void curve_batch_narrow(struct walk *walk, struct stream *stream, uint8_t count);
