// SPDX-License-Identifier: MIT
// The stream of an axis: what its decoder wrote and its ledger accounts for, in one order. Its
// entries stand in the step ring; beside them stand notes of what the entries alone do not tell.
// Main loop only; the step interrupt reads the entries between the two ends and writes nothing.
//
//                   reader's end                            writer's end
//     entries    ...  | retired ...          tail |  ...          head |
//                     |<- made, not accounted for->|<-- still to make ---->|
//     batches         oldest ...                    ... newest     lengths of periods
//     marks           oldest ...                    ... newest     line starts, pixel edges
//     trains          0, 1                                         evenly spaced steps
//
// feed.c, and decode.c for batches, call the functions of the writer's end, ledger.c alone those of
// the reader's end; the others only read. A slot may be written again as soon as the reader has
// passed it, except for the last three, whose periods may still be asked for.
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "ring/step_ring.h" // struct step_ring, struct pulse_train
#include "stream/even.h"    // struct even

// Pixel edges and line starts that can be decoded ahead, a power of two.
#define STREAM_MARKS 16

// Batches whose length the stream remembers for the reader, a power of two; 0: none, the reader
// adds up every period. The build sets 0 for the smaller board, which needs the memory elsewhere.
#if !defined(STREAM_BATCHES)
#define STREAM_BATCHES 8u
#endif

// Single periods join the batch before them until the batch has this many entries: the most that
// is written together, and two around a pixel's edge.
#define STREAM_BATCH_MOST 62u

// Single periods from `slot` on that were written together, or one after the other: the reader
// takes them as a whole instead of adding them up. No mark stands inside a batch.
//
//     marks                         M                   M: behind the first period of its pixel
//     periods    | batch ... | last | first | batch ...
//     batches    |<------- one ------------>|<- the next
struct stream_batch {
    uint8_t slot;
    // Number of entries.
    uint8_t count;
    // Length of all of them, ticks.
    uint32_t ticks;
};

// A place between two periods.
struct stream_mark {
    uint8_t slot; // reached when the reader has passed every entry before this slot
    // Of a pixel that was written as a whole: number of periods behind the mark before. Else the
    // mark is reached this many periods of a train's entry before the slot.
    uint8_t periods : 7;
    // The ledger counts pixels from here; else the mark is a pixel edge.
    bool line_start : 1;
    // Expected position at a pixel edge: signed steps of the line, modulo 2^16. At a line's start:
    // lines that end there, 0 or 1.
    uint16_t position;
    // Of a pixel that was written as a whole: length of these periods together, ticks; 0: not
    // known.
    uint16_t ticks;
};

// A pulse train as it was when it was written; the interrupt changes its own copy.
struct stream_train {
    // Number of steps; 0: the train is free.
    uint16_t steps;
    // Sum of struct even at the start of the train.
    uint16_t sum;
    uint32_t ticks; // of all its steps
};

// Value of stream.behind_periods: the mark that comes next does not tell what lies before it.
#define STREAM_UNKNOWN 0xFFu

struct stream {
    struct step_ring *ring;
    // The STEP_TRAINS trains of the interrupt, or NULL: no trains.
    struct pulse_train *engine_trains;
    // Writer's end: the next slot to write.
    uint8_t head;
    // Reader's end: the first slot that is not accounted for.
    uint8_t retired;
    // The train that was written last, 0 or 1.
    uint8_t newest_train;
    uint8_t mark_head;   // writer: next to write (free running)
    uint8_t mark_placed; // writer: marks before this one have their slot
    uint8_t mark_tail;   // reader: next to pass
    // Writer: periods behind the newest placed mark, if they are those of a pixel written as a
    // whole; else STREAM_UNKNOWN.
    uint8_t behind_periods;
    // Length of these periods together, ticks.
    uint16_t behind_ticks;
    // The end of the newest entry, ticks since the timers started, if no idle period comes before
    // that entry; wraps. Without the delay of a held line.
    uint32_t end_ticks;
    // The writer fills a train that is free, the reader frees a train that is over.
    struct stream_train trains[STEP_TRAINS];
    struct stream_mark marks[STREAM_MARKS];
#if STREAM_BATCHES > 0
    uint8_t batch_head; // writer: next to write (free running)
    uint8_t batch_tail; // reader: next to take
    struct stream_batch batches[STREAM_BATCHES];
#endif
};

// Empty the stream, both ends at `slot`. end_ticks: the end of the newest period that was loaded.
// Keeps the ring and the trains of the interrupt.
void stream_reset(struct stream *stream, uint8_t slot, uint32_t end_ticks);

// Entries that the reader has not passed.
static inline uint8_t stream_used(const struct stream *stream)
{
    return (uint8_t)(stream->head - stream->retired);
}

// Entries that fit.
static inline uint8_t stream_space(const struct stream *stream)
{
    return (uint8_t)(STEP_RING_CAPACITY - stream_used(stream));
}

// Time comes before whatever is not passed yet: idle periods, or the delay of a held line.
static inline void stream_delay(struct stream *stream, uint32_t ticks)
{
    stream->end_ticks += ticks;
}

// The writer's end. The caller keeps to stream_space().

// Write one period into `slot`, while the caller keeps the head. The store of the empty slot behind
// the period comes first and its high byte last, so that the interrupt sees either the old end or
// the new one. Returns the next slot, for stream_note_batch().
static inline uint8_t stream_write(struct step_ring *ring, uint8_t slot, uint16_t ticks)
{
    uint16_t top = (uint16_t)(ticks - 1u);
    uint8_t next = (uint8_t)(slot + 1u);

    ring->high[next] = STEP_HIGH_EMPTY;
    ring->low[slot] = (uint8_t)top;
    ring->high[slot] = (uint8_t)(top >> 8);
    return next;
}

// Append the `count` single periods that stand in the ring from the head on, `ticks` long together.
// When there is no room for another batch, the reader adds these periods up instead.
static inline void stream_note_batch(struct stream *stream, uint8_t count, uint32_t ticks)
{
#if STREAM_BATCHES > 0
    if ((uint8_t)(stream->batch_head - stream->batch_tail) < STREAM_BATCHES) {
        stream->batches[stream->batch_head & (STREAM_BATCHES - 1u)] =
            (struct stream_batch){stream->head, count, ticks};
        stream->batch_head++;
    }
#endif
    stream->head = (uint8_t)(stream->head + count);
    stream->end_ticks += ticks;
}

// stream_note_batch() for `count` periods that the interrupt cannot see yet, because the first
// period's high byte is missing. The store of that byte makes all of them visible at once.
static inline void stream_publish_batch(struct stream *stream,
                                        uint8_t count,
                                        uint32_t ticks,
                                        uint8_t first_high)
{
    stream->ring->high[(uint8_t)(stream->head + count)] = STEP_HIGH_EMPTY;
    stream->ring->high[stream->head] = first_high;
    stream_note_batch(stream, count, ticks);
}

// Append one period. Marks that waited for this period are placed after it.
void stream_put_period(struct stream *stream, uint16_t ticks);

// Append `steps` single periods, `ticks` long together, the first one first_ticks long, that stand
// in the ring from the head on, and a mark that waits for its place behind the period to come. Only
// when one mark waits now: that one is placed behind the first period. The caller shows the periods
// to the interrupt by the high byte of the first.
//
//     marks        M1 waits            M2 waits         M1: behind one period of this pixel
//     periods      | first |  ...  | last |
void stream_put_pixel(struct stream *stream,
                      uint8_t steps,
                      uint32_t ticks,
                      uint16_t first_ticks,
                      uint16_t position);

// Something else than a pixel as a whole is written next.
static inline void stream_lose_count(struct stream *stream)
{
    stream->behind_periods = STREAM_UNKNOWN;
}

// Append a command.
void stream_put_command(struct stream *stream, enum step_command command);

// True when one of the two trains is free, so that stream_put_train() may be called.
static inline bool stream_train_free(const struct stream *stream)
{
    return stream->trains[0].steps == 0 || stream->trains[1].steps == 0;
}

// Which train an entry is of, by its low byte, and how many of its steps the entry stands for.
static inline uint8_t stream_entry_train(int8_t low)
{
    return low < 0 ? 1 : 0;
}

static inline uint8_t stream_entry_steps(int8_t low)
{
    return (uint8_t)(low < 0 ? -low : low);
}

// True while the interrupt, which reads slot `tail` next, makes the older one of two trains in use.
static inline bool stream_in_older_train(const struct stream *stream, uint8_t tail)
{
    uint8_t slot = (uint8_t)(tail - 1u);

    return stream->ring->high[slot] == STEP_HIGH_TRAIN &&
           stream_entry_train((int8_t)stream->ring->low[slot]) != stream->newest_train;
}

// True when a pulse train can make these intervals: they fit one period and differ in their low
// byte only.
static inline bool stream_fits_train(const struct stream *stream, const struct even *even)
{
    return stream->engine_trains != NULL && even->base_ticks < STEP_PERIOD_MAX_TICKS &&
           (even->remainder == 0 || (uint8_t)even->base_ticks != 0);
}

// Append the next `steps` of evenly spaced steps as a pulse train, and pass them in *even. Only
// when stream_train_free() and stream_fits_train(). Marks that waited for the period that carries
// the edge of the step before the train are placed behind the train's first period. Returns the
// train's ticks.
uint32_t stream_put_train(struct stream *stream, struct even *even, uint16_t steps);

// stream_put_train() for all steps that are left in *even, which the caller knows to be `ticks`
// long together: this saves a division. *even stays.
void stream_put_rest(struct stream *stream,
                     const struct even *even,
                     uint16_t steps,
                     uint32_t ticks);

// Leave `count` slots out, the first of which keeps reading empty: the interrupt sees nothing of
// what follows. Returns that slot.
uint8_t stream_reserve(struct stream *stream, uint8_t count);

// True when no further mark fits until the reader passes one.
static inline bool stream_marks_full(const struct stream *stream)
{
    return (uint8_t)(stream->mark_head - stream->mark_tail) >= STREAM_MARKS - 1u;
}

// True when a mark waits for its place.
static inline bool stream_mark_waits(const struct stream *stream)
{
    return stream->mark_placed != stream->mark_head;
}

// True when exactly one mark waits for its place.
static inline bool stream_one_mark_waits(const struct stream *stream)
{
    return (uint8_t)(stream->mark_placed + 1u) == stream->mark_head;
}

// Append a mark that waits for its place. Only when stream_marks_full() is false.
void stream_add_mark(struct stream *stream, bool line_start, uint16_t position);

// Give every waiting mark its place behind the newest entry, `early` periods before its end.
void stream_place_marks(struct stream *stream, uint8_t early);

// The reader's end. `tail` is where the interrupt reads next; the reader never goes beyond it.

// True when there is a mark that has its place.
static inline bool stream_has_mark(const struct stream *stream)
{
    return stream->mark_tail != stream->mark_placed;
}

// The oldest of these marks, if there is one.
static inline const struct stream_mark *stream_mark(const struct stream *stream)
{
    return &stream->marks[stream->mark_tail & (STREAM_MARKS - 1u)];
}

// The mark is reached this many periods of a train's entry before its slot.
static inline uint8_t stream_mark_early(const struct stream_mark *mark)
{
    return mark->ticks != 0 ? 0 : mark->periods;
}

// True when the oldest mark's slot is at most `count` entries ahead of the reader; 0: the reader
// has come to that slot.
static inline bool stream_mark_within(const struct stream *stream, uint8_t count)
{
    return stream_has_mark(stream) &&
           (uint8_t)(stream_mark(stream)->slot - stream->retired) <= count;
}

// Periods that can be passed as a whole up to the oldest mark, mark->ticks long together; 0: it is
// not known how long they are.
static inline uint8_t stream_whole_pixel(const struct stream *stream)
{
    const struct stream_mark *mark = stream_mark(stream);

    return stream_has_mark(stream) && mark->ticks != 0 &&
                   (uint8_t)(mark->slot - mark->periods) == stream->retired
               ? mark->periods
               : 0;
}

// What the marks stand for is not reached any more.
static inline void stream_forget_marks(struct stream *stream)
{
    stream->mark_tail = stream->mark_placed;
}

// True when the interrupt is inside the pixel that was written last as a whole: the mark at the end
// of that pixel has no place yet.
static inline bool stream_inside_newest(const struct stream *stream, uint8_t tail)
{
    return !stream_has_mark(stream) && stream->behind_periods != STREAM_UNKNOWN &&
           (uint8_t)(tail - stream->retired) <= stream->behind_periods;
}

// Length of those periods, ticks.
static inline uint16_t stream_whole_ticks(const struct stream *stream)
{
    return stream_mark(stream)->ticks;
}

// The oldest mark was passed.
static inline void stream_pass_mark(struct stream *stream)
{
    stream->mark_tail++;
}

// The batch that begins where the reader is; NULL: none does.
static inline const struct stream_batch *stream_batch_here(const struct stream *stream)
{
#if STREAM_BATCHES > 0
    const struct stream_batch *batch =
        &stream->batches[stream->batch_tail & (STREAM_BATCHES - 1u)];

    return stream->batch_tail != stream->batch_head && batch->slot == stream->retired
               ? batch
               : NULL;
#else
    (void)stream;
    return NULL;
#endif
}

// Pass that batch, which is over.
static inline void stream_pass_batch(struct stream *stream,
                                     const struct stream_batch *batch)
{
    stream->retired = (uint8_t)(stream->retired + batch->count);
#if STREAM_BATCHES > 0
    stream->batch_tail++;
#endif
}

// True when the interrupt is inside the batch that begins where the reader is.
static inline bool stream_inside_batch(const struct stream *stream, uint8_t tail)
{
    const struct stream_batch *batch = stream_batch_here(stream);

    return batch != NULL && (uint8_t)(tail - stream->retired) < batch->count;
}

// Pass the batches from here on that follow one another up to the next mark and are over: the
// interrupt reads slot `tail` next. Returns the number of their periods, and their length in
// *ticks. Only when no mark stands here.
uint8_t stream_pass_batches(struct stream *stream, uint8_t tail, uint32_t *ticks);

// Kind of the next entry: STEP_HIGH_TRAIN, STEP_HIGH_COMMAND, or less for a single period. Only
// while the reader is not at the interrupt's tail.
static inline uint8_t stream_peek(const struct stream *stream)
{
    return stream->ring->high[stream->retired];
}

// Pass the next entry, a command or one of a train. Returns its low byte.
static inline uint8_t stream_pass_entry(struct stream *stream)
{
    return stream->ring->low[stream->retired++];
}

// Pass more entries of this train (0 or 1), up to slot `tail` or the next mark. Returns the number
// of their steps.
uint16_t stream_pass_train(struct stream *stream, uint8_t train, uint8_t tail);

// Pass single periods up to slot `tail`, the next mark or an entry of another kind, or a batch.
// With `whole` set a batch that the interrupt has not finished is not passed. Returns the number of
// periods, and their length in *ticks; 0: the interrupt is inside such a batch.
uint8_t stream_pass_periods(struct stream *stream,
                            uint8_t tail,
                            bool whole,
                            uint32_t *ticks);

// Length of the single period in this slot, ticks.
static inline uint16_t stream_entry_ticks(const struct stream *stream, uint8_t slot)
{
    uint16_t top_ticks = (uint16_t)(stream->ring->high[slot] << 8);

    return (uint16_t)(top_ticks + stream->ring->low[slot] + 1u);
}

// Length of a single period that the reader has passed, ticks; back: 1 the last one, up to 3.
static inline uint16_t stream_passed_ticks(const struct stream *stream, uint8_t back)
{
    return stream_entry_ticks(stream, (uint8_t)(stream->retired - back));
}

// Ticks from the start of a train (0 or 1) to its step `index` (0: none yet, up to its number of
// steps). Divides.
uint32_t stream_train_ticks(const struct stream *stream, uint8_t train, uint16_t index);

// Length of the shorter intervals of a train (0 or 1), ticks. The longer ones take one tick more.
static inline uint16_t stream_train_base(const struct stream *stream, uint8_t train)
{
    const struct pulse_train *carried = &stream->engine_trains[train];
    uint16_t top_ticks = (uint16_t)((uint16_t)carried->top_high << 8);

    return (uint16_t)(top_ticks + carried->short_low + 1u);
}

// The train (0 or 1) is over.
static inline void stream_free_train(struct stream *stream, uint8_t train)
{
    // The slots of trains name one of the two.
    stream->trains[train].steps = 0; // NOLINT(clang-analyzer-security.ArrayBound)
}
