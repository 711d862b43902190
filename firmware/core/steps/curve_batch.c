// SPDX-License-Identifier: MIT
#include "steps/curve_batch.h"

#include "build_features.h" // SEVERAL_AXES

#if SEVERAL_AXES
void curve_batch_narrow(struct walk *walk, struct stream *stream, uint8_t count)
{
    struct curve_made made;

    curve_flat_burst(
        &walk->steps.curve.state.flat.flat, true, stream->ring, stream->head, count, &made);
    stream_publish_batch(stream, made.steps, made.ticks, made.first_high);
    walk_skip(walk, made.steps, made.ticks);
}
#endif
