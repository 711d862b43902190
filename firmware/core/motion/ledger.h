// SPDX-License-Identifier: MIT
// The ledger follows the step interrupt through the ring and keeps account of what it did: time,
// position, pixel edges. The position is what was handed to the timer, never what was only queued;
// a step counts when its period is loaded, at most one period before its edge. Main loop only.
//
//     ring       | retired ...            tail |  ...       head |
//                |<-- consumed, not accounted ->|<-- decoded ---->|
//     ledger_follow() moves `retired` up to the interrupt's `tail`; the writer may use the slots
//     before `retired` again, except for the last three, whose periods may still be asked for.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "motion/feed.h"        // marks, trains
#include "motion/records.h"     // struct records
#include "motion/step_engine.h" // struct engine_sample

// Value of ledger.train outside a pulse train.
#define LEDGER_NO_TRAIN 0xFFu

// Entries of a pulse train that may wait to be accounted for.
#define LEDGER_LAG_ENTRIES 8u

struct ledger {
    // The ring that the axis's step interrupt reads.
    struct step_ring *ring;
    // First slot that is not accounted for.
    uint8_t retired;
    // Periods at this place of the ring pulse,
    bool pulse;
    // and in this direction.
    bool negative;
    // Periods that are accounted for but not loaded yet; all of them belong to a train.
    uint8_t left;
    // The train at this place, 0 or 1; LEDGER_NO_TRAIN if there is none.
    uint8_t train;
    // Its steps that are accounted for, those of `left` included.
    uint16_t train_steps;
    // Idle periods that are accounted for.
    uint16_t idle_seen;
    // Lengths of the last three single periods before the train, ticks, the newest first.
    uint16_t lengths[3];
    // Number of newer single periods whose lengths are not in lengths[] yet, because they still
    // stand in the ring (0..3).
    uint8_t fresh;
    // Of the periods in lengths[], bit 0 the newest: the period began with a STEP edge.
    uint8_t pulsed;
    // End of the newest single period, ticks since the timers started; wraps.
    uint32_t loaded_ticks;
    // Length of all periods taken from the ring, idle ones excepted; wraps, like loaded_ticks.
    uint32_t taken_ticks;
    // Signed steps since reset, those of `left` included.
    int32_t position_steps;
    // Position where the line began: records count from here.
    int32_t line_origin;
    // Pixel edges passed in the line, so that the newest record is that of this pixel, 1-based.
    uint32_t pixel;
    // Last, so that the members before it lie within reach of a pointer's displacement (63 bytes).
    struct records records;
};

// A new account at position 0. first_period_ticks: length of each of the two periods that the
// timers hold when they start (the interrupt at the end of the first one loads the third).
void ledger_reset(struct ledger *ledger,
                  struct step_ring *ring,
                  uint16_t first_period_ticks);

// The timers were started anew: time begins again at 0; position and records stay.
void ledger_restart(struct ledger *ledger, uint16_t first_period_ticks);

// True when the interrupt is inside the block that begins where the account ends: the block is
// accounted for as a whole once it is over.
static inline bool ledger_inside_block(const struct ledger *ledger,
                                       struct feed *feed,
                                       uint8_t tail)
{
    const struct feed_block *block = feed_next_block(feed);

    return block != NULL && block->slot == ledger->retired &&
           (uint8_t)(tail - ledger->retired) < block->count;
}

// True when the account has reached the next mark already, so that the mark can be consumed though
// nothing more was taken from the ring.
static inline bool ledger_mark_here(const struct ledger *ledger, const struct feed *feed)
{
    return feed->mark_tail != feed->mark_placed &&
           feed->marks[feed->mark_tail & (FEED_MARKS - 1u)].slot == ledger->retired;
}

// False when ledger_follow_blocks() would do nothing, or would only count periods of a train that
// continues: that can wait until somebody asks for the position.
static inline bool ledger_due(const struct ledger *ledger,
                              struct feed *feed,
                              const struct engine_sample *sample)
{
    uint8_t behind = (uint8_t)(sample->tail - ledger->retired);

    if (sample->idle_count != ledger->idle_seen) {
        return true;
    }
    if (ledger->train == LEDGER_NO_TRAIN) {
        return behind != 0 ? !ledger_inside_block(ledger, feed, sample->tail)
                           : ledger_mark_here(ledger, feed);
    }
    // A train that is over must become free.
    if (sample->left == 0 || sample->train != ledger->train || sample->cut ||
        behind >= LEDGER_LAG_ENTRIES) {
        return true;
    }
    return feed->mark_tail != feed->mark_placed &&
           (uint8_t)(feed->marks[feed->mark_tail & (FEED_MARKS - 1u)].slot -
                     ledger->retired) <= behind;
}

// True when the account of an axis at rest is ahead of this sample, so that nothing can be placed
// in time by the sample any more. The number of idle periods tells.
static inline bool ledger_has_passed(const struct ledger *ledger,
                                     const struct engine_sample *sample)
{
    return (int16_t)(sample->idle_count - ledger->idle_seen) < 0;
}

// Account for everything up to the sample. Consumes marks and blocks of the feed, and writes a
// record at each pixel edge that it passes. Samples must not go back in time.
void ledger_follow(struct ledger *ledger,
                   struct feed *feed,
                   const struct engine_sample *sample);

// Account up to the sample, but not into a block that is not over: the block can be accounted for
// as a whole later, at a much lower cost.
void ledger_follow_blocks(struct ledger *ledger,
                          struct feed *feed,
                          const struct engine_sample *sample);

// Position of the axis: signed steps since reset, or since ledger_zero().
static inline int32_t ledger_position(const struct ledger *ledger)
{
    return ledger->negative ? ledger->position_steps + ledger->left
                            : ledger->position_steps - ledger->left;
}

// Steps of the present train whose periods were loaded; 0 outside a train.
static inline uint16_t ledger_train_loaded(const struct ledger *ledger)
{
    return (uint16_t)(ledger->train_steps - ledger->left);
}

// Start of a period, in ticks since the timers started. back: 0 the newest loaded period (the one
// that the timer makes next), 1 the one before, 2 the one before that. Divides inside a train.
//
//     period    | back 2        | back 1: running | back 0: loaded |
//     now                               ^
uint32_t ledger_period_start(struct ledger *ledger,
                             const struct feed *feed,
                             uint8_t back);

// The time of an edge that was captured at this count of period `back`. The capture handler's own
// way is longer than the shortest periods of a train, so that one more period may have begun than
// the handler saw: a count that no period of the train reaches belongs to the period before the
// train.
uint32_t ledger_capture_ticks(struct ledger *ledger,
                              const struct feed *feed,
                              uint8_t back,
                              uint16_t captured_ticks);

// Number of steps in ledger_position() whose edge comes after the time `ticks`, which must not be
// older than the period before the running one. edge_ticks: from the start of a period to its STEP
// edge.
uint8_t ledger_steps_after(struct ledger *ledger,
                           const struct feed *feed,
                           uint32_t ticks,
                           uint8_t edge_ticks);

// Subtract origin_steps from the position, so that this place becomes position 0.
void ledger_zero(struct ledger *ledger, int32_t origin_steps);

// Note by how many ticks the clock edge that ends a pixel missed its planned time; positive when it
// came late. Does nothing when the pixel's record is no longer kept.
void ledger_note_edge_error(struct ledger *ledger, uint32_t pixel, int16_t error_ticks);

// The ring was emptied: nothing before `slot` will be loaded any more, and what follows does not
// pulse until a command says so. Position and time stay.
void ledger_skip_to(struct ledger *ledger, uint8_t slot);
