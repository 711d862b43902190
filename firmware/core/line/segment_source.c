// SPDX-License-Identifier: MIT
#include "line/segment_source.h"

#include "base/apart.h"        // BY_BYTE
#include "build_features.h"    // FEATURE_*
#include "line/segment_pack.h" // segment_unpack

// Take over the flags of a start mark's low byte.
static inline void note_flags(struct segment_source *source, uint8_t flags)
{
    if ((flags & LINE_START_SMOOTH) != 0) {
        source->smooth = true;
    }
    if ((flags & LINE_START_NEGATIVE) != 0) {
        source->negative = true;
    }
    if ((flags & LINE_START_SEEK) != 0) {
        source->ends_early = true;
    }
}

struct segment segment_source_begin(struct segment_source *source,
                                    struct segment_queue *queue)
{
    source->queue = queue;
    uint16_t word = (uint16_t)segment_unpack(&queue->out).count;
    struct segment parameter = segment_unpack(&queue->out);
    uint8_t flags = (uint8_t)word;
    uint8_t more = (uint8_t)(word >> 8);

    BY_BYTE(flags);
    BY_BYTE(more);
    if (FEATURE_LINE_DIVIDER && (more & LINE_START_DIVIDER >> 8) != 0) {
        (void)segment_unpack(&queue->out); // counted when it was queued
    }
    note_flags(source, flags);
    return parameter;
}

// True when the segment in work has pixels left to make. A seek that has tripped leaves out pixels
// until its slowdown begins, the first one below `speed`, the line's.
static bool has_pixels(struct segment_source *source, uint16_t speed)
{
    if (source->segment.repeat == 0) {
        return false;
    }
    if (!FEATURE_HOMING) {
        return true;
    }
    if (source->leaving_out && source->down && segment_source_steps(source) < speed) {
        source->leaving_out = false;
    }
    return !source->leaving_out;
}

enum segments segment_source_next(struct segment_source *source, uint16_t speed)
{
    while (!has_pixels(source, speed)) {
        // A kind of source that makes its segments itself is asked here (see the header).
        if (!segment_queue_pop(source->queue, &source->segment)) {
            return SEGMENTS_DRY;
        }
        if (source->segment.repeat == 0) {
            if (!FEATURE_HOMING || source->segment.count != (int16_t)LINE_MARK_DOWN) {
                return source->smooth && speed != 0 ? SEGMENTS_DRY : SEGMENTS_OVER;
            }
            source->down = true;
        }
    }
    return SEGMENTS_PIXELS;
}

void segment_source_trip(struct segment_source *source)
{
    source->leaving_out = !source->down;
}
