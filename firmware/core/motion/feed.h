// SPDX-License-Identifier: MIT
// The writer's side of the step ring: intervals in, timer periods and commands out.
//
// A period begins with its STEP edge, so an interval's periods carry the edge of the step that
// came BEFORE it (the lead); the step at its end is carried by the next interval's first period.
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

// Pixel edges (and line starts) that can be decoded ahead, a power of two.
#define FEED_MARKS 8u

// Bursts of single periods whose sum the writer knows: so many of them are remembered for the
// ledger, a power of two; 0: none, the ledger adds up every period. The build takes the smaller
// board's memory for other things.
#if !defined(FEED_BLOCKS)
#define FEED_BLOCKS 8u
#endif

// Single pulsing periods, from slot on.
struct feed_block {
    uint8_t slot;
    uint8_t count;
    uint32_t ticks; // together
};

// A place in the stream of entries, for the ledger that follows the interrupt.
struct feed_mark {
    uint8_t slot;      // reached when the ledger has passed every entry before this slot,
    uint8_t early : 7; //   but for so many periods of a run's entry
    bool line_start : 1; // count from here; else a pixel edge
    uint16_t position;   // expected signed steps of the line at a pixel edge, modulo 2^16
};

// What a run was when it was written; the interrupt's own half changes.
struct feed_train {
    uint16_t steps; // 0: the run is free
    uint16_t sum;   // struct even's, where it begins
    uint32_t ticks; // of all its steps
};

struct feed {
    struct step_ring *ring;
    struct pulse_train
        *engine_trains;      // STEP_TRAINS runs that the interrupt carries on, or NULL
    uint16_t reversal_ticks; // from a change of direction to the next step, at least
    struct feed_train trains[STEP_TRAINS];
    uint8_t newest_train;
    uint8_t head;      // next slot to write
    bool pulse;        // what the entries written so far leave behind: pulsing,
    bool negative;     //   and direction
    bool lead;         // the next period begins with a STEP edge
    bool step_due;     // pending_ticks ends with a step
    bool due_negative; // its direction
    bool held;         // the front of the line is not released yet
    bool merge;        // the next interval may be merged into the delay before the line
    uint8_t held_slot;
    uint32_t lead_in_ticks; // part of the first interval that the delay must cover
    uint32_t pending_ticks; // time decoded but not written
    uint32_t written_ticks; // lengths of all periods written (wraps)
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

void feed_reset(struct feed *feed, struct step_ring *ring, uint8_t head);

// Entries that fit; `retired` is the first slot the ledger still needs.
static inline uint8_t feed_space(const struct feed *feed, uint8_t retired)
{
    return (uint8_t)(STEP_RING_CAPACITY - (uint8_t)(feed->head - retired));
}

// Most entries that one call of the functions below writes.
#define FEED_BURST 8u

// Longest delay of feed_release().
#define FEED_DELAY_MAX_TICKS (2uL * STEP_PERIOD_MAX_TICKS)

// Reserve the held front; the line's intervals follow.
void feed_hold(struct feed *feed);

// Publish the held front so that the line begins after delay_ticks (2..FEED_DELAY_MAX_TICKS,
// including lead_in_ticks); the delay becomes two periods of about half that each. Call with the
// step interrupt unable to load another idle period: all of it,
void feed_release(struct feed *feed, uint32_t delay_ticks);
// or only the single store in the middle of its three parts.
void feed_fill_front(struct feed *feed,
                     uint32_t delay_ticks); // still invisible; may be repeated
static inline void feed_publish_front(struct feed *feed)
{
    feed->ring->high[feed->held_slot] = STEP_HIGH_COMMAND;
}
void feed_front_released(struct feed *feed, uint32_t delay_ticks); // after the store

// Time that passes, then a step. Only when !feed_busy().
void feed_step(struct feed *feed, uint32_t interval_ticks, bool negative);

// True when steps in this direction need nothing but one period each; feed_burst_put() may then be
// called feed_space() times instead of feed_step(), for intervals up to STEP_PERIOD_MAX_TICKS.
static inline bool feed_plain(const struct feed *feed, bool negative)
{
    return feed->lead && feed->pulse && feed->pending_ticks == 0 &&
           negative == feed->negative && feed->mark_placed == feed->mark_head;
}

// The sentinel first, the high byte last: the interrupt sees the old end or the new one. Returns
// the next slot; feed->head is the caller's to update.
static inline uint8_t feed_burst_put(struct step_ring *ring, uint8_t slot, uint16_t ticks)
{
    uint16_t top = (uint16_t)(ticks - 1u);
    uint8_t next = (uint8_t)(slot + 1u);

    ring->high[next] = STEP_HIGH_EMPTY;
    ring->low[slot] = (uint8_t)top;
    ring->high[slot] = (uint8_t)(top >> 8);
    return next;
}

// True when steps in this direction may be handed over as a run.
static inline bool feed_steady(const struct feed *feed, bool negative)
{
    return feed->lead && feed->pending_ticks == 0 && negative == feed->negative;
}

static inline bool feed_train_free(const struct feed *feed)
{
    return feed->trains[0].steps == 0 || feed->trains[1].steps == 0;
}

// The interrupt can carry these intervals: they fit one period and differ in their low byte only.
bool feed_fits_train(const struct feed *feed, const struct even *even);

// Evenly spaced steps, `ticks` long in all. Only when feed_steady(), feed_train_free() and
// feed_fits_train(). `even` is as it was before these steps.
void feed_train(struct feed *feed,
                const struct even *even,
                uint16_t steps,
                uint32_t ticks);

// Ticks from the start of a run to its step `index` (0: none yet). Divides.
uint32_t feed_train_ticks(const struct feed *feed, uint8_t train, uint16_t index);

// Length of its shorter intervals, ticks.
static inline uint16_t feed_train_base(const struct feed *feed, uint8_t train)
{
    const struct pulse_train *carried = &feed->engine_trains[train];

    uint16_t top_ticks = (uint16_t)((uint16_t)carried->top_high << 8);

    return (uint16_t)(top_ticks + carried->short_low + 1u);
}

// So many entries from slot on were put as single periods, `ticks` together.
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

// The next block, NULL if there is none.
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

// It was taken.
static inline void feed_drop_block(struct feed *feed)
{
#if FEED_BLOCKS > 0
    feed->block_tail++;
#else
    (void)feed;
#endif
}

// Time that passes without a step at its end. Only when !feed_busy().
void feed_quiet(struct feed *feed, uint32_t ticks);

// Write what is pending, as far as FEED_BURST entries go; call while feed_busy() and space lasts.
void feed_pump(struct feed *feed);

// After a mark. When it was the last that fits, the time of zero pixels that is not written yet
// must not wait for more of them: all of it but what a reversal needs becomes a period of its own.
void feed_make_room(struct feed *feed);

static inline bool feed_busy(const struct feed *feed)
{
    return feed->step_due || feed->pending_ticks > STEP_PERIOD_MAX_TICKS;
}

static inline bool feed_marks_full(const struct feed *feed)
{
    return (uint8_t)(feed->mark_head - feed->mark_tail) >= FEED_MARKS - 1u;
}

// A pixel edge or a line start, after everything fed so far.
void feed_mark_here(struct feed *feed, bool line_start, int32_t position);

// The line is over and nothing follows it without a gap. Only when !feed_busy().
void feed_end(struct feed *feed);
