// SPDX-License-Identifier: MIT
#include "stream/stream.h"

#include "base/apart.h"         // APART
#include "base/require.h"       // REQUIRE
#include "build_features.h"     // SEVERAL_AXES
#include "ring/step_ring_sum.h" // step_ring_sum

// A place is noted behind so many single periods since the newest waypoint,
#define PLACE_PERIODS 24u
// and while fewer waypoints than this are in use.
#define PLACE_WAYPOINTS 10u

APART void stream_reset(struct stream *stream, uint8_t slot, uint32_t end_ticks)
{
    stream->head = slot;
    stream->retired = slot;
    stream->waypoint_head = 0;
    stream->waypoint_placed = 0;
    stream->waypoint_tail = 0;
    stream->plain = 0;
    stream->end_ticks = end_ticks;
    stream->delay_ticks = 0;
    stream->trains[0].steps = 0;
    stream->trains[1].steps = 0;
    stream->ring->high[slot] = STEP_HIGH_EMPTY;
}

// Place the waypoint that is next in turn at `slot`, where time is `ticks`.
static struct waypoint *place_next(struct stream *stream, uint8_t slot, uint32_t ticks)
{
    struct waypoint *waypoint =
        &stream->waypoints[stream->waypoint_placed++ & (STREAM_WAYPOINTS - 1u)];

    waypoint->slot = slot;
    waypoint_set_ticks(waypoint, ticks);
    return waypoint;
}

// Note a place behind the newest entry, where many single periods lead there and there are
// waypoints enough for pixel edges, too. A single axis has the time to add up.
static void note_place(struct stream *stream, uint8_t from)
{
    if (SEVERAL_AXES && stream->plain != 0 &&
        (uint8_t)(stream->head - from) >= PLACE_PERIODS &&
        (uint8_t)(stream->waypoint_head - stream->waypoint_tail) < PLACE_WAYPOINTS) {
        stream->waypoint_head++;
        place_next(stream, stream->head, stream->end_ticks)->way = WAYPOINT_PLACE;
    }
}

void stream_add_periods(struct stream *stream, uint8_t count, uint32_t ticks)
{
    uint8_t newest = (uint8_t)(stream->waypoint_placed - 1u) & (STREAM_WAYPOINTS - 1u);
    uint8_t from =
        stream_has_waypoint(stream) ? stream->waypoints[newest].slot : stream->retired;

    stream->head = (uint8_t)(stream->head + count);
    stream->end_ticks += ticks;
    note_place(stream, from);
}

void stream_put_period(struct stream *stream, uint16_t ticks)
{
    stream->head = stream_write(stream->ring, stream->head, ticks);
    stream->end_ticks += ticks;
    stream_place_waypoints(stream, 0);
}

// Append an entry that is no period. It is stored like a period whose high byte says so.
static void put_entry(struct stream *stream, uint16_t high_low)
{
    stream->plain = 0;
    stream->head = stream_write(stream->ring, stream->head, (uint16_t)(high_low + 1u));
}

void stream_put_command(struct stream *stream, enum step_command command)
{
    put_entry(stream, (uint16_t)((uint16_t)STEP_HIGH_COMMAND << 8 | (uint8_t)command));
}

static inline void fill_train(struct pulse_train *train, const struct even *even)
{
    uint16_t top = (uint16_t)(even->base_ticks - 1u);
    int16_t after_long = (int16_t)(even->remainder - even->steps);

    train->after_short = (int16_t)even->remainder;
    train->after_long = after_long;
    train->sum = (int16_t)(even->sum + (uint16_t)after_long);
    train->short_low = (uint8_t)top;
    train->long_low = (uint8_t)(top + 1u);
    train->top_high = (uint8_t)(top >> 8);
}

// Fill the train that is free. Returns which it is.
static inline uint8_t begin_train(struct stream *stream,
                                  const struct even *even,
                                  uint16_t steps)
{
    uint8_t train = stream->trains[0].steps == 0 ? 0 : 1;

    REQUIRE(stream->trains[train].steps == 0);
    fill_train(&stream->engine_trains[train], even);
    stream->trains[train].steps = steps;
    stream->trains[train].sum = even->sum;
    return train;
}

// Append the entries of the train that was filled.
static inline void put_train(struct stream *stream,
                             uint8_t train,
                             uint16_t steps,
                             uint32_t ticks)
{
    stream->newest_train = train;
    stream->newest_train_ticks = ticks;
    while (steps != 0) {
        uint8_t now =
            steps > STEP_TRAIN_ENTRY_MAX ? STEP_TRAIN_ENTRY_MAX : (uint8_t)steps;
        // The sign of the number of steps tells which train.
        uint8_t low = train == 0 ? now : (uint8_t)-now;
        put_entry(stream, (uint16_t)((uint16_t)STEP_HIGH_TRAIN << 8 | low));
        stream_place_waypoints(stream, (uint8_t)(now - 1u));
        steps = (uint16_t)(steps - now);
    }
    stream->end_ticks += ticks;
}

uint32_t stream_put_train(struct stream *stream, struct even *even, uint16_t steps)
{
    BY_POINTER_SMALL(stream);
    uint8_t train = begin_train(stream, even, steps);
    uint32_t ticks = even_skip(even, steps);

    put_train(stream, train, steps, ticks);
    return ticks;
}

void stream_put_rest(struct stream *stream,
                     const struct even *even,
                     uint16_t steps,
                     uint32_t ticks)
{
    put_train(stream, begin_train(stream, even, steps), steps, ticks);
}

uint8_t stream_reserve(struct stream *stream, uint8_t count)
{
    uint8_t slot = stream->head;

    stream->plain = 0;
    stream->head = (uint8_t)(slot + count);
    stream->ring->high[stream->head] = STEP_HIGH_EMPTY;
    return slot;
}

void stream_add_waypoint(struct stream *stream, bool line_start, uint16_t position)
{
    struct waypoint *waypoint =
        &stream->waypoints[stream->waypoint_head++ & (STREAM_WAYPOINTS - 1u)];

    waypoint->way = 0;
    waypoint->position = position;
    if (line_start) {
        waypoint->way = WAYPOINT_START;
        stream->plain = 0;
    }
}

void stream_place_waypoints(struct stream *stream, uint8_t early)
{
    while (stream_waypoint_waits(stream)) {
        struct waypoint *waypoint = place_next(stream, stream->head, stream->end_ticks);

        if (waypoint->way == 0) {
            waypoint->way = stream->plain;
        }
        waypoint->way |= early;
        stream->plain = early == 0 ? WAYPOINT_PLAIN : 0;
    }
}

void stream_put_pixel(struct stream *stream,
                      uint8_t steps,
                      uint32_t ticks,
                      uint16_t first_ticks,
                      uint16_t position)
{
    struct waypoint *waypoint =
        place_next(stream, (uint8_t)(stream->head + 1u), stream->end_ticks + first_ticks);

    waypoint->way |= stream->plain;
    stream->plain = WAYPOINT_PLAIN;
    stream->head = (uint8_t)(stream->head + steps);
    stream->ring->high[stream->head] = STEP_HIGH_EMPTY;
    stream->end_ticks += ticks;
    stream_add_waypoint(stream, false, position);
}

// The sooner one of two slots, seen from the reader's end.
static uint8_t sooner(const struct stream *stream, uint8_t one, uint8_t other)
{
    bool first = (uint8_t)(one - stream->retired) < (uint8_t)(other - stream->retired);

    return first ? one : other;
}

// Where the reader has to stop on its way to slot `tail`: at the next waypoint, or there.
static uint8_t next_stop(const struct stream *stream, uint8_t tail)
{
    return stream_has_waypoint(stream)
               ? sooner(stream, stream_waypoint(stream)->slot, tail)
               : tail;
}

uint8_t stream_pass_periods(struct stream *stream, uint8_t tail, uint32_t *ticks)
{
    uint8_t first = stream->retired;

    *ticks = step_ring_sum(stream->ring, &stream->retired, next_stop(stream, tail));
    return (uint8_t)(stream->retired - first);
}

uint16_t stream_pass_train(struct stream *stream, uint8_t train, uint8_t tail)
{
    const struct step_ring *ring = stream->ring;
    uint8_t slot = stream->retired;
    uint8_t stop = next_stop(stream, tail);
    uint16_t steps = 0;

    for (; slot != stop && ring->high[slot] == STEP_HIGH_TRAIN; slot++) {
        int8_t count = (int8_t)ring->low[slot];
        if (stream_entry_train(count) != train) {
            break;
        }
        steps = (uint16_t)(steps + stream_entry_steps(count));
    }
    stream->retired = slot;
    return steps;
}

uint32_t stream_train_ticks(const struct stream *stream, uint8_t train, uint16_t index)
{
    const struct pulse_train *carried = &stream->engine_trains[train];
    struct even even = {
        .base_ticks = stream_train_base(stream, train),
        .remainder = (uint16_t)carried->after_short,
        .steps = (uint16_t)(carried->after_short - carried->after_long),
        .sum = stream->trains[train].sum,
    };

    return even_skip(&even, index);
}
