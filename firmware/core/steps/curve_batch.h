// SPDX-License-Identifier: MIT
// A batch of steps of a curve: made, shown to the interrupt and noted for the account at once.
// Where several axes move, this is most of what the main loop does for a smooth line. Main loop
// only.
#pragma once

#include <stdint.h>

#include "build_features.h" // SEVERAL_AXES
#include "steps/walk.h"     // struct walk
#include "stream/stream.h"  // struct stream

// Most steps of a batch; the second holds for a low ring. With several axes the ledger accounts for
// such a batch as a whole, so that a batch's slots stay in use until then.
#define CURVE_BATCH     (SEVERAL_AXES ? 60u : 120u)
#define CURVE_BATCH_LOW 16u

// The most steps of a batch when the ring has so many entries.
static inline uint8_t curve_batch_most(uint8_t fill)
{
    if (fill < CURVE_BATCH_LOW) {
        return CURVE_BATCH_LOW;
    }
    return fill > CURVE_BATCH ? (uint8_t)CURVE_BATCH : fill;
}

// Make `count` ordinary steps of the walk: what curve_narrow() has returned and the ring has room
// for. With several axes only.
void curve_batch_narrow(struct walk *walk, struct stream *stream, uint8_t count);
