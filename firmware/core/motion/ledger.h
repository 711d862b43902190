// SPDX-License-Identifier: MIT
// Follows the step interrupt through the ring and keeps what it did: time, position, pixel edges.
// Position is what was handed to the timer, never what was only queued; a step counts when its
// period is loaded, at most one period before its edge.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "motion/feed.h"        // marks, runs
#include "motion/records.h"     // struct records
#include "motion/step_engine.h" // struct engine_sample

#define LEDGER_NO_TRAIN 0xFFu

// Entries of a run that may wait to be accounted for.
#define LEDGER_LAG_ENTRIES 8u

struct ledger {
    struct step_ring *ring;
    uint8_t retired; // first slot not yet accounted for
    bool pulse;
    bool negative;
    uint8_t left;  // of the entries accounted for: periods not loaded yet, all of a run
    uint8_t train; // the run being carried, LEDGER_NO_TRAIN if none
    uint16_t train_steps; //   its steps accounted for
    uint16_t idle_seen;   // idle periods accounted for
    uint16_t
        lengths[3]; // of the last three periods before the run, ticks, newest first, less
    uint8_t fresh;  //   so many newer ones that still stand in the ring (0..3)
    uint8_t pulsed; // of those in lengths[], bit 0 the newest: it began with a STEP edge
    uint32_t
        loaded_ticks; // end of the newest period before the run, since the timers started
    uint32_t taken_ticks; // of all periods taken from the ring, not idle ones; both wrap
    int32_t position_steps; // since reset, signed, with the periods not loaded yet
    int32_t line_origin;    // position where the line began
    uint32_t pixel;         // edges passed in the line
    // Last, so that what stands before it lies within reach of a pointer's displacement (63 bytes).
    struct records records;
};

// first_period_ticks: length of the two periods that are settled when the timers start (the
// interrupt at the end of the first one loads the third).
void ledger_reset(struct ledger *ledger,
                  struct step_ring *ring,
                  uint16_t first_period_ticks);

// The timers were started anew: time begins again, position and records stay.
void ledger_restart(struct ledger *ledger, uint16_t first_period_ticks);

// The interrupt is inside a block that begins where the account ends.
static inline bool ledger_inside_block(const struct ledger *ledger,
                                       struct feed *feed,
                                       uint8_t tail)
{
    const struct feed_block *block = feed_next_block(feed);

    return block != NULL && block->slot == ledger->retired &&
           (uint8_t)(tail - ledger->retired) < block->count;
}

// The next mark was placed where the account has come already.
static inline bool ledger_mark_here(const struct ledger *ledger, const struct feed *feed)
{
    return feed->mark_tail != feed->mark_placed &&
           feed->marks[feed->mark_tail & (FEED_MARKS - 1u)].slot == ledger->retired;
}

// False when ledger_follow_blocks() would do nothing, or only count periods of a run that goes on:
// that can wait until somebody asks.
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
    // The run that is over must be known as free.
    if (sample->left == 0 || sample->train != ledger->train || sample->cut ||
        behind >= LEDGER_LAG_ENTRIES) {
        return true;
    }
    return feed->mark_tail != feed->mark_placed &&
           (uint8_t)(feed->marks[feed->mark_tail & (FEED_MARKS - 1u)].slot -
                     ledger->retired) <= behind;
}

// A sample of an axis now at rest whose account has come further already: nothing can be placed by
// it any more.
static inline bool ledger_has_passed(const struct ledger *ledger,
                                     const struct engine_sample *sample)
{
    return (int16_t)(sample->idle_count - ledger->idle_seen) < 0;
}

// Account for everything up to the sample. Takes marks and blocks from the feed. Main loop only.
void ledger_follow(struct ledger *ledger,
                   struct feed *feed,
                   const struct engine_sample *sample);

// The same, but for a block that is not over yet: it can be taken as a whole later, at much less
// cost.
void ledger_follow_blocks(struct ledger *ledger,
                          struct feed *feed,
                          const struct engine_sample *sample);

// Signed steps since reset.
static inline int32_t ledger_position(const struct ledger *ledger)
{
    return ledger->negative ? ledger->position_steps + ledger->left
                            : ledger->position_steps - ledger->left;
}

// Steps of the run that were loaded; 0 when there is none.
static inline uint16_t ledger_train_loaded(const struct ledger *ledger)
{
    return (uint16_t)(ledger->train_steps - ledger->left);
}

// Start of a period relative to the newest loaded one: 0 that one itself, 1 the one before, 2.
// Divides, inside a run.
uint32_t ledger_period_start(struct ledger *ledger,
                             const struct feed *feed,
                             uint8_t back);

// The instant of an edge captured at this count of period `back`. The capture's own way is longer
// than the shortest periods of a run, so that one more may have begun than it knows: a count that
// no period of the run reaches is of the period before the run.
uint32_t ledger_capture_ticks(struct ledger *ledger,
                              const struct feed *feed,
                              uint8_t back,
                              uint16_t captured_ticks);

// Of the steps in ledger_position(), those whose edge comes after an instant that is no older than
// the period before the running one. edge_ticks: from the start of a period to its STEP edge.
uint8_t ledger_steps_after(struct ledger *ledger,
                           const struct feed *feed,
                           uint32_t ticks,
                           uint8_t edge_ticks);

// From here on the position is counted from `origin_steps`.
void ledger_zero(struct ledger *ledger, int32_t origin_steps);

// The clock edge that ends a pixel was seen so many ticks after its planned place.
void ledger_note_edge_error(struct ledger *ledger, uint32_t pixel, int16_t error_ticks);

// The ring was emptied by force: nothing before `slot` will be loaded any more.
void ledger_skip_to(struct ledger *ledger, uint8_t slot);
