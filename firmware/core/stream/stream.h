// SPDX-License-Identifier: MIT
// The stream of an axis: what its decoder wrote and its ledger accounts for, in one order. Its
// entries stand in the step ring; beside them stand waypoints, which tell what the entries alone do
// not. Main loop only; the step interrupt reads the entries between the two ends and writes
// nothing.
//
//                   reader's end                            writer's end
//     entries    ...  | retired ...          tail |  ...          head |
//                     |<- made, not accounted for->|<-- still to make ---->|
//     waypoints       oldest ...                    ... newest     line starts, pixel edges, places
//     trains          0, 1                                         evenly spaced steps
//
// feed.c and the writers of whole pixels call the functions of the writer's end. The account alone
// (core/account) calls those of the reader's end. All others only read. A slot may be written again
// as soon as the reader has passed it, except for the last three, whose periods may still be asked
// for.
//
// No function checks its range: the caller keeps to stream_space(), stream_train_free() and
// stream_waypoints_full(), which say what fits.
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "ring/step_ring.h" // struct step_ring, struct pulse_train
#include "stream/even.h"    // struct even

// Size of the ring of waypoints, a power of two. One less can be written ahead.
#define STREAM_WAYPOINTS 16

// Member `way` of a waypoint: how the reader gets there, in the lower 7 bits, and what the waypoint
// is, in the upper bit.
//
//     way       the waypoint is    and lies
//     00..7E    a pixel edge       that many periods of a train before the end of the last entry
//     7F        a pixel edge       at its slot; single periods alone lead there
//     80..FE    a line start       that many periods of a train before the end of the last entry
//     FF        a place            at its slot; single periods alone lead there
//
// The lower bits of a pixel edge to which single periods alone lead from the waypoint before.
#define WAYPOINT_PLAIN 0x7Fu
// A place of known time, and nothing else. Boards of several axes note places on long ways.
#define WAYPOINT_PLACE 0xFFu
// The upper bit. A line start: the ledger counts the line's pixels and positions from here.
#define WAYPOINT_START 0x80u

// The reader may leave single periods to be passed as a whole, at the next waypoint, while it lags
// fewer entries than this behind the interrupt.
#define STREAM_LAG_MOST 124u

// A place between two periods, which the account jumps to when the interrupt has passed it.
//
//     periods    | | | | | | | | |          the account jumps by slot where single periods alone
//     waypoints    ^edge 1    place^        stand between; else it takes entry by entry
//
// The writer's end writes a waypoint and places it; the reader's end only reads it.
struct waypoint {
    // The waypoint is reached when the reader has passed every entry before this slot.
    uint8_t slot;
    // WAYPOINT_PLAIN and the others.
    uint8_t way;
    // Expected position at a pixel edge: signed steps of the line, modulo 2^16.
    uint16_t position;
    // If single periods alone lead here: the end of the last of them as the stream's end_ticks has
    // it, low 24 bits. All periods of a ring together are shorter than 2^24 ticks.
    uint16_t ticks_low;
    // Bits 16 to 23 of that time.
    uint8_t ticks_high;
};

// Set the time of a waypoint; the bits of `ticks` above the lowest 24 are dropped.
static inline void waypoint_set_ticks(struct waypoint *waypoint, uint32_t ticks)
{
    waypoint->ticks_low = (uint16_t)ticks;
    waypoint->ticks_high = (uint8_t)(ticks >> 16);
}

// The time of a waypoint, ticks, low 24 bits, as end_ticks of struct stream counts.
static inline uint32_t waypoint_ticks(const struct waypoint *waypoint)
{
    return (uint32_t)waypoint->ticks_high << 16 | waypoint->ticks_low;
}

// A pulse train as it was when it was written; the interrupt changes its own copy.
struct stream_train {
    // Number of steps of the train, 1..32767; 0: the train is free.
    uint16_t steps;
    // Member `sum` of struct even at the start of the train.
    uint16_t sum;
};

// The state of both ends. "Writer" and "reader" name the end that writes a member.
struct stream {
    // The ring that the step interrupt reads. axis_init() sets it.
    struct step_ring *ring;
    // The STEP_TRAINS trains of the interrupt, or NULL: no trains. axis_init() sets it.
    struct pulse_train *engine_trains;
    // Writer: the next slot to write; always reads as empty.
    uint8_t head;
    // Reader: the first slot that is not accounted for.
    uint8_t retired;
    // Writer: the train that was written last, 0 or 1.
    uint8_t newest_train;
    // Writer: number of the next waypoint to write. The three numbers run freely, modulo 256; the
    // lowest bits of a number are the waypoint's index.
    uint8_t waypoint_head;
    // Writer: waypoints before the one with this number have their slot, the others wait for it.
    uint8_t waypoint_placed;
    // Reader: number of the next waypoint to pass.
    uint8_t waypoint_tail;
    // Writer: WAYPOINT_PLAIN if single periods alone were written since the newest waypoint that
    // has its slot, else 0.
    uint8_t plain;
    // Writer: the end of the newest entry, ticks since the timers started, without delay_ticks;
    // wraps.
    uint32_t end_ticks;
    // Time that has come before entries since stream_reset(), ticks: idle periods, which the reader
    // adds, and the delay of a held line, which the writer adds. Wraps.
    uint32_t delay_ticks;
    // Writer: length of the train that was written last, all its steps together, ticks.
    uint32_t newest_train_ticks;
    // The writer fills a train that is free, the reader frees a train that is over.
    struct stream_train trains[STEP_TRAINS];
    // The ring of the waypoints.
    struct waypoint waypoints[STREAM_WAYPOINTS];
};

// Empty the stream, both ends at `slot`, without waypoints and with both trains free. end_ticks:
// the end of the newest period that was loaded. Keeps the ring and the trains of the interrupt.
// The interrupt must read `slot` next, and take nothing before.
void stream_reset(struct stream *stream, uint8_t slot, uint32_t end_ticks);

// Entries that the reader has not passed, 0..STEP_RING_CAPACITY; those of a held front count too.
static inline uint8_t stream_used(const struct stream *stream)
{
    return (uint8_t)(stream->head - stream->retired);
}

// Entries that may be written now, 0..STEP_RING_CAPACITY.
static inline uint8_t stream_space(const struct stream *stream)
{
    return (uint8_t)(STEP_RING_CAPACITY - stream_used(stream));
}

// `ticks` of time come before whatever is not passed yet: idle periods, or the delay of a held
// line. Both ends call this.
static inline void stream_delay(struct stream *stream, uint32_t ticks)
{
    stream->delay_ticks += ticks;
}

// The end of the newest entry, ticks since the timers started, if no more idle period comes before
// that entry; wraps. Without the delay of a held line.
static inline uint32_t stream_end_ticks(const struct stream *stream)
{
    return stream->end_ticks + stream->delay_ticks;
}

// The writer's end. The caller keeps to stream_space().

// Write one period of 1..STEP_PERIOD_MAX_TICKS ticks into `slot`, while the head stays as it is.
// The slot after the period is made to read as empty first, and the period's high byte is stored
// last, so that the interrupt sees either the old end or the new one. Returns the next slot.
// stream_add_periods() must follow.
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
// Only when no waypoint waits for its slot. On boards of several axes this also notes a place where
// many periods lead on from the newest waypoint.
void stream_add_periods(struct stream *stream, uint8_t count, uint32_t ticks);

// stream_add_periods() for `count` periods (1 or more) that the interrupt cannot see yet, because
// the first period's high byte, first_high, is missing. The store of that byte makes all of them
// visible at once.
static inline void stream_publish_batch(struct stream *stream,
                                        uint8_t count,
                                        uint32_t ticks,
                                        uint8_t first_high)
{
    stream->ring->high[(uint8_t)(stream->head + count)] = STEP_HIGH_EMPTY;
    stream->ring->high[stream->head] = first_high;
    stream_add_periods(stream, count, ticks);
}

// Append one period of 1..STEP_PERIOD_MAX_TICKS ticks. Waypoints that waited for this period are
// placed after it.
void stream_put_period(struct stream *stream, uint16_t ticks);

// Append a pixel of `steps` single periods, `ticks` long together, the first one first_ticks long.
// Only when exactly one waypoint waits: that one is placed after the first period. A new waypoint
// with this position waits for the period that follows the pixel. The caller writes the periods
// into the ring from the old head on, before this call or afterwards, and shows them to the
// interrupt by storing the high byte of the first one last of all.
//
//     periods      |  first  |  ...  |  last  | the period to come |
//     waypoints              ^ W1                                  ^ W2, placed later
void stream_put_pixel(struct stream *stream,
                      uint8_t steps,
                      uint32_t ticks,
                      uint16_t first_ticks,
                      uint16_t position);

// Append a command, which takes one entry and no time.
void stream_put_command(struct stream *stream, enum step_command command);

// True when one of the two trains is free, so that stream_put_train() may be called.
static inline bool stream_train_free(const struct stream *stream)
{
    return stream->trains[0].steps == 0 || stream->trains[1].steps == 0;
}

// Which train an entry is of, 0 or 1, by its low byte.
static inline uint8_t stream_entry_train(int8_t low)
{
    return low < 0 ? 1 : 0;
}

// How many steps of that train, 1..127, the entry stands for.
static inline uint8_t stream_entry_steps(int8_t low)
{
    return (uint8_t)(low < 0 ? -low : low);
}

// True while the interrupt, which reads slot `tail` next, has taken an entry of another train than
// the newest one last: it makes the older of two trains in use.
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

// Append the next `steps` (1 or more) of evenly spaced steps as a pulse train, and pass them in
// *even. Only when stream_train_free() and stream_fits_train(), and when there is room for an entry
// for each STEP_TRAIN_ENTRY_MAX steps. Waypoints that waited for the period that carries the edge
// of the step before the train are placed after the train's first period. Returns the train's
// ticks. Divides, except for all steps of the piece at once.
uint32_t stream_put_train(struct stream *stream, struct even *even, uint16_t steps);

// stream_put_train() for all steps that are left in *even, `steps` of them, which the caller knows
// to be `ticks` long together: this saves a division. *even stays as it is.
void stream_put_rest(struct stream *stream,
                     const struct even *even,
                     uint16_t steps,
                     uint32_t ticks);

// Leave `count` slots out, the first of which keeps reading empty: the interrupt sees nothing of
// what follows until the caller fills that slot last of all. Returns that slot.
uint8_t stream_reserve(struct stream *stream, uint8_t count);

// True when no further waypoint fits until the reader passes one. Waypoints that wait count too.
static inline bool stream_waypoints_full(const struct stream *stream)
{
    return (uint8_t)(stream->waypoint_head - stream->waypoint_tail) >=
           STREAM_WAYPOINTS - 1u;
}

// True when a waypoint waits for its place.
static inline bool stream_waypoint_waits(const struct stream *stream)
{
    return stream->waypoint_placed != stream->waypoint_head;
}

// True when exactly one waypoint waits for its place.
static inline bool stream_one_waypoint_waits(const struct stream *stream)
{
    return (uint8_t)(stream->waypoint_placed + 1u) == stream->waypoint_head;
}

// Append a waypoint that waits for its place: a line start or a pixel edge. position: of a pixel
// edge, expected signed steps of the line, modulo 2^16. Only when stream_waypoints_full() is false.
void stream_add_waypoint(struct stream *stream, bool line_start, uint16_t position);

// Give every waiting waypoint its place after the newest entry, or, if that is an entry of a train,
// `early` (0..126) periods before its end.
void stream_place_waypoints(struct stream *stream, uint8_t early);

// The reader's end. `tail` is where the interrupt reads next; the reader never goes beyond it.

// True when there is a waypoint that has its place and was not passed.
static inline bool stream_has_waypoint(const struct stream *stream)
{
    return stream->waypoint_tail != stream->waypoint_placed;
}

// The oldest of these waypoints. Only when stream_has_waypoint().
static inline const struct waypoint *stream_waypoint(const struct stream *stream)
{
    return &stream->waypoints[stream->waypoint_tail & (STREAM_WAYPOINTS - 1u)];
}

// True when single periods alone lead to this waypoint.
static inline bool waypoint_is_plain(const struct waypoint *waypoint)
{
    return (waypoint->way & WAYPOINT_PLAIN) == WAYPOINT_PLAIN;
}

// How many periods of a train's entry, 0..126, the waypoint lies before its slot.
static inline uint8_t waypoint_early(const struct waypoint *waypoint)
{
    return waypoint_is_plain(waypoint) ? 0 : waypoint->way & WAYPOINT_PLAIN;
}

// True when the oldest waypoint's slot is at most `count` entries ahead of the reader; 0: the
// reader has come to that slot.
static inline bool stream_waypoint_within(const struct stream *stream, uint8_t count)
{
    return stream_has_waypoint(stream) &&
           (uint8_t)(stream_waypoint(stream)->slot - stream->retired) <= count;
}

// Drop the waypoints that have their place: what they stand for is not reached any more.
static inline void stream_forget_waypoints(struct stream *stream)
{
    stream->waypoint_tail = stream->waypoint_placed;
}

// True when the reader has passed every waypoint, and single periods alone were written after the
// newest one.
static inline bool stream_is_open(const struct stream *stream)
{
    return !stream_has_waypoint(stream) && stream->plain != 0;
}

// True when the interrupt, which reads slot `tail` next, is on its way from the reader to a
// waypoint by single periods alone: they may wait to be passed as a whole.
static inline bool stream_on_plain_way(const struct stream *stream, uint8_t tail)
{
    uint8_t made = (uint8_t)(tail - stream->retired);

    if (made >= STREAM_LAG_MOST) {
        return false;
    }
    if (!stream_has_waypoint(stream)) {
        return stream->plain != 0;
    }
    const struct waypoint *next = stream_waypoint(stream);

    return waypoint_is_plain(next) && made < (uint8_t)(next->slot - stream->retired);
}

// The oldest waypoint was passed. Only when stream_has_waypoint().
static inline void stream_pass_waypoint(struct stream *stream)
{
    stream->waypoint_tail++;
}

// Kind of the next entry: STEP_HIGH_TRAIN, STEP_HIGH_COMMAND, or less for a single period. Only
// while the reader is not at the interrupt's tail.
static inline uint8_t stream_peek(const struct stream *stream)
{
    return stream->ring->high[stream->retired];
}

// Pass the next entry, a command or an entry of a train. Returns its low byte. Only while the
// reader is not at the interrupt's tail.
static inline uint8_t stream_pass_entry(struct stream *stream)
{
    return stream->ring->low[stream->retired++];
}

// Pass more entries of this train (0 or 1), up to slot `tail`, the next waypoint or another entry.
// Returns the number of their steps, which is 0 when the reader passed nothing.
uint16_t stream_pass_train(struct stream *stream, uint8_t train, uint8_t tail);

// Pass single periods up to slot `tail`, the next waypoint or an entry of another kind. Returns the
// number of periods, 0..252, and their length together in *ticks.
uint8_t stream_pass_periods(struct stream *stream, uint8_t tail, uint32_t *ticks);

// Length of the single period in this slot, 1..STEP_PERIOD_MAX_TICKS ticks. The slot must hold one.
static inline uint16_t stream_entry_ticks(const struct stream *stream, uint8_t slot)
{
    uint16_t top_ticks = (uint16_t)(stream->ring->high[slot] << 8);

    return (uint16_t)(top_ticks + stream->ring->low[slot] + 1u);
}

// Length of the shorter intervals of a train (0 or 1), ticks. The longer ones take one tick more.
// The train must be in use, and the stream must have trains.
static inline uint16_t stream_train_base(const struct stream *stream, uint8_t train)
{
    const struct pulse_train *carried = &stream->engine_trains[train];
    uint16_t top_ticks = (uint16_t)((uint16_t)carried->top_high << 8);

    return (uint16_t)(top_ticks + carried->short_low + 1u);
}

// Length of the newest period, ticks: the interrupt needs the next entry when it begins. In a train
// it may take one tick more. After stream_reset() only when something was written.
static inline uint16_t stream_newest_ticks(const struct stream *stream)
{
    uint8_t slot = (uint8_t)(stream->head - 1u);

    while (stream->ring->high[slot] == STEP_HIGH_COMMAND) {
        slot--;
    }
    if (stream->ring->high[slot] == STEP_HIGH_TRAIN) {
        int8_t low = (int8_t)stream->ring->low[slot];
        return stream_train_base(stream, stream_entry_train(low));
    }
    return stream_entry_ticks(stream, slot);
}

// Length of a single period that the reader has passed, ticks; back: 1 the last one, up to 3. The
// last `back` entries must be single periods.
static inline uint16_t stream_passed_ticks(const struct stream *stream, uint8_t back)
{
    return stream_entry_ticks(stream, (uint8_t)(stream->retired - back));
}

// Ticks from the start of a train (0 or 1) to its step `index` (0: none yet, up to its number of
// steps). The train must be in use. Divides, as even_skip() does.
uint32_t stream_train_ticks(const struct stream *stream, uint8_t train, uint16_t index);

// The train (0 or 1) is over, or was cut: the writer may fill it again.
static inline void stream_free_train(struct stream *stream, uint8_t train)
{
    // The slots of trains name one of the two.
    stream->trains[train].steps = 0; // NOLINT(clang-analyzer-security.ArrayBound)
}
