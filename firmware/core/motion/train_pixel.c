// SPDX-License-Identifier: MIT
#include "motion/train_pixel.h"

#include "base/apart.h"        // APART
#include "motion/even_pixel.h" // EVEN_PIXEL_MAX_STEPS
#include "motion/line.h"       // struct line

// Of such a pixel, the steps in front of its train included.
#define MAX_ENTRIES (TRAIN_STAGGER_MAX + TRAIN_PIXEL_MAX_ENTRIES)

uint32_t train_pixel_singles(struct even *even, struct stream *stream, uint8_t count)
{
    struct step_ring *ring = stream->ring;
    struct even next = *even;
    uint16_t base_ticks = (uint16_t)next.base_ticks;
    uint8_t slot = stream->head;
    uint32_t sum = 0;

    // These intervals fit 16 bits, so that only the tick above the base comes from even_next().
    next.base_ticks = 0;
    for (; count != 0; count--) {
        uint16_t ticks = (uint16_t)(base_ticks + even_next(&next));
        sum += ticks;
        slot = stream_write(ring, slot, ticks);
    }
    even->sum = next.sum;
    stream_note_batch(stream, (uint8_t)(slot - stream->head), sum);
    return sum;
}

// Write the steps in front of the train; the mark that waits is placed behind the first of them.
// Returns their ticks.
static uint32_t put_stagger(struct even *even, struct stream *stream, uint8_t stagger)
{
    uint16_t first_ticks = (uint16_t)even_next(even);

    stream_put_period(stream, first_ticks);
    return first_ticks + train_pixel_singles(even, stream, (uint8_t)(stagger - 1u));
}

static void put_pixel(struct even *even,
                      struct stream *stream,
                      uint32_t ticks,
                      uint8_t stagger)
{
    if (even->base_ticks < TRAIN_ENTRY_MIN_TICKS) {
        stagger = 0;
    }
    if (stagger != 0) {
        ticks -= put_stagger(even, stream, stagger);
    }
    stream_put_rest(stream, even, (uint16_t)(even->steps - stagger), ticks);
}

APART enum train_pixel train_pixel_write(struct line *line,
                                         struct even *even,
                                         struct stream *stream,
                                         bool negative,
                                         uint8_t stagger)
{
    uint16_t steps = line_many_steps(line, negative);

    // Where a train has less room than the longest needs, it is written in parts, as a piece is.
    if (steps <= EVEN_PIXEL_MAX_STEPS || steps > TRAIN_PIXEL_MAX_STEPS ||
        stream_marks_full(stream) || stream_space(stream) < MAX_ENTRIES) {
        return TRAIN_PIXEL_OTHER;
    }
    if (!stream_train_free(stream)) {
        return stream->trains[stream->newest_train].ticks >= TRAIN_WAIT_TICKS
                   ? TRAIN_PIXEL_WAITS
                   : TRAIN_PIXEL_OTHER;
    }
    uint32_t ticks = line_known_ticks(line);

    even_start(even, ticks, steps);
    if (!stream_fits_train(stream, even)) {
        return TRAIN_PIXEL_OTHER;
    }
    put_pixel(even, stream, ticks, stagger);
    line->curve_half = 0;
    line->speed = steps;
    line_pass_even(line, (int16_t)(negative ? -(int16_t)steps : (int16_t)steps));
    stream_add_mark(stream, false, (uint16_t)line->position);
    stream_lose_count(stream);
    return TRAIN_PIXEL_DONE;
}
