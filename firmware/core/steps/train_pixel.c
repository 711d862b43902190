// SPDX-License-Identifier: MIT
#include "steps/train_pixel.h"

#include "base/apart.h"       // APART
#include "base/multiply.h"    // multiply_u32_u16
#include "build_features.h"   // SEVERAL_AXES
#include "line/line.h"        // struct line
#include "steps/even_pixel.h" // EVEN_PIXEL_MAX_STEPS

// Of such a pixel, the steps in front of its train included.
#define MAX_ENTRIES (TRAIN_STAGGER_MAX + TRAIN_PIXEL_MAX_ENTRIES)

#if defined(__AVR__) && SEVERAL_AXES

struct even_singles {
    // Intervals that are a tick longer than the others.
    uint8_t longer;
    // The first period's high byte, which the caller stores: the interrupt sees them all by it.
    uint8_t first_high;
};

// Write the next `count` steps, 1 or more, into the ring from `slot` on: even_singles.S.
struct even_singles even_singles_write(struct even *even,
                                       struct step_ring *ring,
                                       uint8_t slot,
                                       uint8_t count);

uint32_t train_pixel_singles(struct even *even, struct stream *stream, uint8_t count)
{
    struct even_singles made =
        even_singles_write(even, stream->ring, stream->head, count);
    uint32_t ticks = multiply_u32_u16(even->base_ticks, count) + made.longer;

    stream_publish_batch(stream, count, ticks, made.first_high);
    return ticks;
}

#else

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
    stream_add_periods(stream, (uint8_t)(slot - stream->head), sum);
    return sum;
}

#endif

// Write the steps in front of the train; the waypoint that waits is placed behind the first of
// them. Returns their ticks.
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

// Write the pixel whose steps *even walks along: as a train, or its first step where no train can
// make it.
static inline enum train_pixel put_steps(struct even *even,
                                         struct stream *stream,
                                         uint32_t ticks,
                                         uint16_t steps,
                                         uint8_t stagger)
{
    if (!stream_fits_train(stream, even)) {
        if (even->base_ticks >= STEP_PERIOD_MAX_TICKS) {
            return TRAIN_PIXEL_OTHER;
        }
        stream_put_period(stream, (uint16_t)even_next(even));
        return TRAIN_PIXEL_SINGLES;
    }
    if (steps > TRAIN_PIXEL_MAX_STEPS) {
        return TRAIN_PIXEL_OTHER;
    }
    put_pixel(even, stream, ticks, stagger);
    return TRAIN_PIXEL_DONE;
}

APART enum train_pixel train_pixel_write(struct line *line,
                                         struct even *even,
                                         struct stream *stream,
                                         bool negative,
                                         uint8_t stagger)
{
    uint16_t steps = line_many_steps(line, negative);

    // Where a train has less room than the longest needs, it is written in parts, as a piece is.
    if (steps <= EVEN_PIXEL_MAX_STEPS || stream_waypoints_full(stream) ||
        stream_space(stream) < MAX_ENTRIES) {
        return TRAIN_PIXEL_OTHER;
    }
    if (!stream_train_free(stream)) {
        return steps <= TRAIN_PIXEL_MAX_STEPS &&
                       stream->newest_train_ticks >= TRAIN_WAIT_TICKS
                   ? TRAIN_PIXEL_WAITS
                   : TRAIN_PIXEL_OTHER;
    }
    uint32_t ticks = line_known_ticks(line);

    even_start(even, ticks, steps);
    enum train_pixel made = put_steps(even, stream, ticks, steps, stagger);

    if (made == TRAIN_PIXEL_OTHER) {
        return made;
    }
    line->curve_half = 0;
    line->speed = steps;
    line_pass_even(line, (int16_t)(negative ? -(int16_t)steps : (int16_t)steps));
    if (made == TRAIN_PIXEL_DONE) {
        stream_add_waypoint(stream, false, (uint16_t)line->position);
    }
    return made;
}
