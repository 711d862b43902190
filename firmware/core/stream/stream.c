// SPDX-License-Identifier: MIT
#include "stream/stream.h"

#include "base/apart.h"         // APART
#include "base/require.h"       // REQUIRE
#include "ring/step_ring_sum.h" // step_ring_sum

APART void stream_reset(struct stream *stream, uint8_t slot, uint32_t end_ticks)
{
    stream->head = slot;
    stream->retired = slot;
    stream->mark_head = 0;
    stream->mark_placed = 0;
    stream->mark_tail = 0;
    stream_lose_count(stream);
    stream->end_ticks = end_ticks;
    stream->trains[0].steps = 0;
    stream->trains[1].steps = 0;
#if STREAM_BATCHES > 0
    stream->batch_head = 0;
    stream->batch_tail = 0;
#endif
    stream->ring->high[slot] = STEP_HIGH_EMPTY;
}

// The single periods around a pixel's edge are accounted for with the batch in front of them: the
// period to be written joins the newest batch if it follows that, the reader has not passed the
// batch, and no mark stands in between.
static inline void continue_batch(struct stream *stream, uint16_t ticks)
{
#if STREAM_BATCHES > 0
    uint8_t head = stream->head;
    uint8_t number = (uint8_t)(stream->batch_head - 1u) & (STREAM_BATCHES - 1u);
    struct stream_batch *newest = &stream->batches[number];
    uint8_t count = newest->count;

    if (stream->batch_head == stream->batch_tail || count >= STREAM_BATCH_MOST ||
        (uint8_t)(newest->slot + count) != head) {
        return;
    }
    number = (uint8_t)(stream->mark_placed - 1u) & (STREAM_MARKS - 1u);
    if (!stream_has_mark(stream) || stream->marks[number].slot != head) {
        newest->count = (uint8_t)(count + 1u);
        newest->ticks += ticks;
    }
#else
    (void)stream;
    (void)ticks;
#endif
}

void stream_put_period(struct stream *stream, uint16_t ticks)
{
    continue_batch(stream, ticks);
    stream->head = stream_write(stream->ring, stream->head, ticks);
    stream->end_ticks += ticks;
    stream_place_marks(stream, 0);
}

// Append an entry that is no period. It is stored like a period whose high byte says so.
static void put_entry(struct stream *stream, uint16_t high_low)
{
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
    stream->trains[train].ticks = ticks;
    stream->newest_train = train;
    while (steps != 0) {
        uint8_t now =
            steps > STEP_TRAIN_ENTRY_MAX ? STEP_TRAIN_ENTRY_MAX : (uint8_t)steps;
        // The sign of the number of steps tells which train.
        uint8_t low = train == 0 ? now : (uint8_t)-now;
        put_entry(stream, (uint16_t)((uint16_t)STEP_HIGH_TRAIN << 8 | low));
        stream_place_marks(stream, (uint8_t)(now - 1u));
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

    stream->head = (uint8_t)(slot + count);
    stream->ring->high[stream->head] = STEP_HIGH_EMPTY;
    return slot;
}

void stream_add_mark(struct stream *stream, bool line_start, uint16_t position)
{
    struct stream_mark *mark = &stream->marks[stream->mark_head & (STREAM_MARKS - 1u)];

    mark->periods = 0;
    mark->line_start = line_start;
    mark->ticks = 0;
    mark->position = position;
    stream->mark_head++;
}

void stream_place_marks(struct stream *stream, uint8_t early)
{
    while (stream_mark_waits(stream)) {
        struct stream_mark *mark =
            &stream->marks[stream->mark_placed & (STREAM_MARKS - 1u)];
        mark->slot = stream->head;
        mark->periods = early & 0x7Fu;
        stream->mark_placed++;
    }
}

// Note what lies between the mark before and this one, and what the pixel leaves behind this one.
static void count_periods(struct stream *stream,
                          struct stream_mark *mark,
                          uint8_t steps,
                          uint32_t ticks,
                          uint16_t first_ticks)
{
    uint16_t behind_ticks = stream->behind_ticks;

    uint16_t whole_ticks = (uint16_t)(behind_ticks + first_ticks);

    if (stream->behind_periods != STREAM_UNKNOWN && whole_ticks >= behind_ticks) {
        mark->periods = (uint8_t)(stream->behind_periods + 1u) & 0x7Fu;
        mark->ticks = whole_ticks;
    }
    stream->behind_periods = ticks <= UINT16_MAX ? (uint8_t)(steps - 1u) : STREAM_UNKNOWN;
    stream->behind_ticks = (uint16_t)(ticks - first_ticks);
}

void stream_put_pixel(struct stream *stream,
                      uint8_t steps,
                      uint32_t ticks,
                      uint16_t first_ticks,
                      uint16_t position)
{
    struct stream_mark *mark =
        &stream->marks[stream->mark_placed++ & (STREAM_MARKS - 1u)];

    mark->slot = (uint8_t)(stream->head + 1u);
    count_periods(stream, mark, steps, ticks, first_ticks);
    stream->head = (uint8_t)(stream->head + steps);
    stream->ring->high[stream->head] = STEP_HIGH_EMPTY;
    stream->end_ticks += ticks;
    stream_add_mark(stream, false, position);
}

// The sooner one of two slots, seen from the reader's end.
static uint8_t sooner(const struct stream *stream, uint8_t one, uint8_t other)
{
    bool first = (uint8_t)(one - stream->retired) < (uint8_t)(other - stream->retired);

    return first ? one : other;
}

// The oldest batch, NULL if there is none.
static struct stream_batch *oldest_batch(struct stream *stream)
{
#if STREAM_BATCHES > 0
    return stream->batch_tail == stream->batch_head
               ? NULL
               : &stream->batches[stream->batch_tail & (STREAM_BATCHES - 1u)];
#else
    (void)stream;
    return NULL;
#endif
}

uint8_t stream_pass_batches(struct stream *stream, uint8_t tail, uint32_t *ticks)
{
    uint8_t first = stream->retired;
    const struct stream_batch *batch = stream_batch_here(stream);

    *ticks = 0;
    while (batch != NULL && batch->count <= (uint8_t)(tail - stream->retired)) {
        *ticks += batch->ticks;
        stream_pass_batch(stream, batch);
        batch = stream_mark_within(stream, 0) ? NULL : stream_batch_here(stream);
    }
    return (uint8_t)(stream->retired - first);
}

uint8_t stream_pass_periods(struct stream *stream,
                            uint8_t tail,
                            bool whole,
                            uint32_t *ticks)
{
    struct stream_batch *batch = oldest_batch(stream);
    uint8_t first = stream->retired;
    uint8_t stop =
        stream_has_mark(stream) ? sooner(stream, stream_mark(stream)->slot, tail) : tail;
    bool at_batch = batch != NULL && batch->slot == first;

    if (at_batch) {
        uint8_t count = stream_pass_batches(stream, tail, ticks);
        if (count != 0 || whole) {
            return count;
        }
    } else if (batch != NULL) {
        stop = sooner(stream, batch->slot, stop);
    }
    *ticks = step_ring_sum(stream->ring, &stream->retired, stop);
    uint8_t count = (uint8_t)(stream->retired - first);
    if (at_batch) {
        batch->slot = stream->retired;
        batch->count = (uint8_t)(batch->count - count);
        batch->ticks -= *ticks;
    }
    return count;
}

uint16_t stream_pass_train(struct stream *stream, uint8_t train, uint8_t tail)
{
    const struct step_ring *ring = stream->ring;
    uint8_t slot = stream->retired;
    uint8_t stop =
        stream_has_mark(stream) ? sooner(stream, stream_mark(stream)->slot, tail) : tail;
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
