// SPDX-License-Identifier: MIT
#include "motion/curve_batch.h"

#include <stddef.h> // offsetof

#include "build_features.h" // SEVERAL_AXES
#include "motion/curve_batch_layout.h"

#if SEVERAL_AXES
#if defined(__AVR__)

_Static_assert(offsetof(struct walk, steps.curve.state.flat.flat) == 0 &&
                   offsetof(struct walk, until) == CURVE_BATCH_UNTIL &&
                   offsetof(struct walk, exact_ticks) == CURVE_BATCH_EXACT_TICKS,
               "known to curve_batch.S");
_Static_assert(offsetof(struct stream, ring) == CURVE_BATCH_RING &&
                   offsetof(struct stream, head) == CURVE_BATCH_HEAD &&
                   offsetof(struct stream, end_ticks) == CURVE_BATCH_END_TICKS &&
                   offsetof(struct stream, batch_head) == CURVE_BATCH_NEXT &&
                   offsetof(struct stream, batch_tail) == CURVE_BATCH_NEXT + 1 &&
                   offsetof(struct stream, batches) ==
                       CURVE_BATCH_NEXT + CURVE_BATCH_NOTES &&
                   sizeof(struct stream_batch) == CURVE_BATCH_NOTE &&
                   STREAM_BATCHES == CURVE_BATCH_COUNT &&
                   STEP_HIGH_EMPTY == CURVE_BATCH_EMPTY,
               "known to curve_batch.S");

#else

// As curve_batch.S does it, for every other processor.
void curve_batch_narrow(struct walk *walk, struct stream *stream, uint8_t count)
{
    struct curve_made made;

    curve_burst(&walk->steps.curve, stream->ring, stream->head, count, &made);
    stream_publish_batch(stream, made.steps, made.ticks, made.first_high);
    walk_skip(walk, made.steps, made.ticks);
}

#endif
#endif
