// SPDX-License-Identifier: MIT
// The writer's side of the step ring: intervals in, timer periods and commands out. Main loop only.
//
// A period begins with its STEP edge. The periods of an interval therefore carry the edge of the
// step BEFORE the interval (the lead), and the first period of the next interval carries the step
// at its end.
//
//     steps      s1          s2                            s3
//     intervals  |---- d2 ---|------------- d3 ------------|---
//     periods    |P    d2    |P  32768  |Q     the rest    |P       P pulses, Q does not
//
// A line that waits for the pixel clock is decoded ahead behind a held slot: the ring looks empty
// to the interrupt until feed_release() fills that slot and the delay behind it.
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "motion/even.h"      // struct even
#include "motion/step_ring.h" // struct step_ring, struct pulse_train

// Pixel edges and line starts that can be decoded ahead, a power of two.
#define FEED_MARKS 8u

// Blocks whose length the feed remembers for the ledger, a power of two; 0: none, the ledger adds
// up every period. The build sets 0 for the smaller board, which needs the memory elsewhere.
#if !defined(FEED_BLOCKS)
#define FEED_BLOCKS 8u
#endif

// Single pulsing periods that were written together, from `slot` on: the ledger accounts for them
// as a whole instead of adding them up.
struct feed_block {
    uint8_t slot;
    // Number of entries.
    uint8_t count;
    // Length of all of them, ticks.
    uint32_t ticks;
};

// A place in the stream of entries, for the ledger that follows the interrupt.
struct feed_mark {
    uint8_t slot;      // reached when the ledger has passed every entry before this slot,
    uint8_t early : 7; //   but for so many periods of a train's entry
    // The ledger counts pixels from here; else the mark is a pixel edge.
    bool line_start : 1;
    // Expected position at a pixel edge: signed steps of the line, modulo 2^16.
    uint16_t position;
};

// A pulse train as it was when it was written; the interrupt changes its own copy.
struct feed_train {
    // Number of steps; 0: the train is free.
    uint16_t steps;
    // Sum of struct even at the start of the train.
    uint16_t sum;
    uint32_t ticks; // of all its steps
};

// The decoder writes these members by the functions below; the ledger reads marks, blocks and
// trains and drops what it has consumed.
struct feed {
    // The ring that this feed alone writes.
    struct step_ring *ring;
    // The STEP_TRAINS trains of the interrupt, or NULL: no trains.
    struct pulse_train *engine_trains;
    // Shortest time from a change of direction to the next step, ticks; app/limits.c sets it.
    uint16_t reversal_ticks;
    // The trains that are not over yet; the ledger frees them.
    struct feed_train trains[STEP_TRAINS];
    // The train that was written last, 0 or 1.
    uint8_t newest_train;
    // Next slot to write.
    uint8_t head;
    bool pulse;    // what the entries written so far leave behind: pulsing,
    bool negative; //   and direction
    // The next period begins with a STEP edge.
    bool lead;
    // pending_ticks ends with a step
    bool step_due;
    // in this direction.
    bool due_negative;
    // The front of the line is not released yet.
    bool held;
    // The next interval may be merged into the delay before the line.
    bool merge;
    // The slot that hides the front while `held` is set.
    uint8_t held_slot;
    // Part of the first interval that the delay must cover, ticks.
    uint32_t lead_in_ticks;
    // Time that is decoded but not written, ticks.
    uint32_t pending_ticks;
    // Length of all periods written, ticks; wraps.
    uint32_t written_ticks;
#if FEED_BLOCKS > 0
    struct feed_block blocks[FEED_BLOCKS];
    uint8_t block_head; // next to write (free running)
    uint8_t block_tail; // next for the ledger
#endif
    uint8_t mark_head;   // next to write (free running)
    uint8_t mark_placed; // marks before this one have their slot
    uint8_t mark_tail;   // next for the ledger
    // Last, so that what stands before it lies within reach of a pointer's displacement (63 bytes).
    struct feed_mark marks[FEED_MARKS];
};

// An empty feed that writes from slot `head` on. Keeps the trains, the reversal time and the
// direction.
void feed_reset(struct feed *feed, struct step_ring *ring, uint8_t head);

// Entries that fit; `retired` is the first slot that the ledger still needs.
static inline uint8_t feed_space(const struct feed *feed, uint8_t retired)
{
    return (uint8_t)(STEP_RING_CAPACITY - (uint8_t)(feed->head - retired));
}

// Most entries that one call of the functions below writes.
#define FEED_BURST 8u

// Longest delay of feed_release(), ticks.
#define FEED_DELAY_MAX_TICKS (2uL * STEP_PERIOD_MAX_TICKS)

// Reserve the held front: its begin command and two delay periods. The line's intervals follow. The
// ring reads empty to the interrupt until feed_release().
void feed_hold(struct feed *feed);

// Publish the held front so that the line begins after delay_ticks (2..FEED_DELAY_MAX_TICKS,
// lead_in_ticks included); the delay becomes two periods of about half of it each. Called where the
// step interrupt cannot load another idle period meanwhile. The same in three parts, of which only
// the second must not be interrupted:
void feed_release(struct feed *feed, uint32_t delay_ticks);
// first: fill the front, which stays invisible; may be repeated;
void feed_fill_front(struct feed *feed,
                     uint32_t delay_ticks); // still invisible; may be repeated
// second: the single store that publishes the front;
static inline void feed_publish_front(struct feed *feed)
{
    feed->ring->high[feed->held_slot] = STEP_HIGH_COMMAND;
}
// third: account for the front, after the store.
void feed_front_released(struct feed *feed, uint32_t delay_ticks);

// Add interval_ticks and then a step in this direction. Only when feed_busy() is false; the feed
// may be busy afterwards, so that feed_pump() must write the rest.
void feed_step(struct feed *feed, uint32_t interval_ticks, bool negative);

// True when each step in this direction needs nothing but one period. feed_burst_put() may then be
// called feed_space() times instead of feed_step(), for intervals up to STEP_PERIOD_MAX_TICKS.
static inline bool feed_plain(const struct feed *feed, bool negative)
{
    return feed->lead && feed->pulse && feed->pending_ticks == 0 &&
           negative == feed->negative && feed->mark_placed == feed->mark_head;
}

// Write one period. The store of the empty slot behind it comes first and the high byte last, so
// that the interrupt sees either the old end or the new one. Returns the next slot; the caller
// updates feed->head.
static inline uint8_t feed_burst_put(struct step_ring *ring, uint8_t slot, uint16_t ticks)
{
    uint16_t top = (uint16_t)(ticks - 1u);
    uint8_t next = (uint8_t)(slot + 1u);

    ring->high[next] = STEP_HIGH_EMPTY;
    ring->low[slot] = (uint8_t)top;
    ring->high[slot] = (uint8_t)(top >> 8);
    return next;
}

// True when steps in this direction may be handed over as a pulse train.
static inline bool feed_steady(const struct feed *feed, bool negative)
{
    return feed->lead && feed->pending_ticks == 0 && negative == feed->negative;
}

// True when one of the two trains is free, so that feed_train() may be called.
static inline bool feed_train_free(const struct feed *feed)
{
    return feed->trains[0].steps == 0 || feed->trains[1].steps == 0;
}

// True when a pulse train can make these intervals: they fit one period and differ in their low
// byte only.
bool feed_fits_train(const struct feed *feed, const struct even *even);

// Hand over `steps` evenly spaced steps, `ticks` long together, as a pulse train. Only when
// feed_steady(), feed_train_free() and feed_fits_train(). `even` is as it was before these steps.
void feed_train(struct feed *feed,
                const struct even *even,
                uint16_t steps,
                uint32_t ticks);

// Ticks from the start of a train (0 or 1) to its step `index` (0: none yet, up to its number of
// steps). Divides.
uint32_t feed_train_ticks(const struct feed *feed, uint8_t train, uint16_t index);

// Length of the shorter intervals of a train (0 or 1), ticks. The longer ones take one tick more.
static inline uint16_t feed_train_base(const struct feed *feed, uint8_t train)
{
    const struct pulse_train *carried = &feed->engine_trains[train];

    uint16_t top_ticks = (uint16_t)((uint16_t)carried->top_high << 8);

    return (uint16_t)(top_ticks + carried->short_low + 1u);
}

// `count` entries from `slot` on were written as single periods, `ticks` long together. When there
// is no room for another block, the ledger adds these periods up instead.
static inline void feed_note_block(struct feed *feed,
                                   uint8_t slot,
                                   uint8_t count,
                                   uint32_t ticks)
{
    feed->written_ticks += ticks;
#if FEED_BLOCKS > 0
    if ((uint8_t)(feed->block_head - feed->block_tail) < FEED_BLOCKS) {
        feed->blocks[feed->block_head & (FEED_BLOCKS - 1u)] =
            (struct feed_block){slot, count, ticks};
        feed->block_head++;
    }
#else
    (void)slot;
    (void)count;
#endif
}

// The oldest block that the ledger has not consumed, NULL if there is none. Valid until the next
// feed_drop_block().
static inline struct feed_block *feed_next_block(struct feed *feed)
{
#if FEED_BLOCKS > 0
    return feed->block_tail == feed->block_head
               ? NULL
               : &feed->blocks[feed->block_tail & (FEED_BLOCKS - 1u)];
#else
    (void)feed;
    return NULL;
#endif
}

// The ledger has consumed that block.
static inline void feed_drop_block(struct feed *feed)
{
#if FEED_BLOCKS > 0
    feed->block_tail++;
#else
    (void)feed;
#endif
}

// Add time without a step at its end. Only when feed_busy() is false.
void feed_quiet(struct feed *feed, uint32_t ticks);

// Write pending time, FEED_BURST entries at most. Call it while feed_busy() and while there is
// space.
void feed_pump(struct feed *feed);

// After a mark. When the mark was the last that fits, the time of zero pixels that is not written
// yet must not wait for more of them: all of it except what a reversal needs becomes a period of
// its own.
void feed_make_room(struct feed *feed);

// True when time or a step is pending that feed_pump() must write first; feed_step() and feed_end()
// must wait until then.
static inline bool feed_busy(const struct feed *feed)
{
    return feed->step_due || feed->pending_ticks > STEP_PERIOD_MAX_TICKS;
}

// True when no further mark fits until the ledger consumes one. The decoder waits.
static inline bool feed_marks_full(const struct feed *feed)
{
    return (uint8_t)(feed->mark_head - feed->mark_tail) >= FEED_MARKS - 1u;
}

// Place a pixel edge or a line start behind everything fed so far. position: expected position at
// the edge, signed steps of the line. Only when feed_marks_full() is false.
void feed_mark_here(struct feed *feed, bool line_start, int32_t position);

// The line is over, and nothing follows it without a gap: write the last step's period and the end
// command. Only when feed_busy() is false.
void feed_end(struct feed *feed);
