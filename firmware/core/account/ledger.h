// SPDX-License-Identifier: MIT
// The reader's end of an axis's stream: the account of what the step interrupt made of it, that is
// time, position and pixel edges. The position is what was handed to the timer, never what was only
// written; a step counts when its period is loaded, at most one period before its edge. Main loop
// only.
//
//     stream     | retired ...            tail |  ...       head |
//                |<-- made, not accounted for ->|<-- decoded --->|
//
// ledger_advance() alone moves the account: from waypoint to waypoint where single periods alone
// stand between, and else entry by entry, up to the interrupt's `tail`.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "account/ledger_data.h"      // struct ledger
#include "account/ledger_waypoints.h" // ledger_pass_waypoints
#include "build_features.h"           // SEVERAL_AXES
#include "ring/step_engine.h"         // struct engine_sample
#include "stream/stream.h"            // struct stream

// Entries of a pulse train that may wait to be accounted for.
#define LEDGER_LAG_ENTRIES 8u

// A new account at position 0. first_period_ticks: length of each of the two periods that the
// timers hold when they start (the interrupt at the end of the first one loads the third).
void ledger_reset(struct ledger *ledger, uint16_t first_period_ticks);

// The timers were started again: time begins at 0; position and records stay. The stream must
// be reset afterwards.
void ledger_restart(struct ledger *ledger, uint16_t first_period_ticks);

// How far ledger_advance() goes.
enum ledger_extent {
    // To the sample.
    LEDGER_EXACTLY,
    // Not into single periods that a waypoint follows: later they are passed at a much lower cost.
    LEDGER_BY_WAYPOINTS,
};

// False when an advance by waypoints would do nothing, or would only count periods of a train that
// continues: that can wait until somebody asks for the position.
static inline bool ledger_due(const struct ledger *ledger,
                              const struct stream *stream,
                              const struct engine_sample *sample)
{
    uint8_t behind = (uint8_t)(sample->tail - stream->retired);

    if (sample->idle_count != ledger->idle_seen) {
        return true;
    }
    if (ledger->train == LEDGER_NO_TRAIN) {
        if (behind != 0) {
            return !stream_on_plain_way(stream, sample->tail);
        }
    } else if (sample->left == 0 || sample->train != ledger->train || sample->cut ||
               behind >= LEDGER_LAG_ENTRIES) {
        return true; // a train that is over must become free
    }
    return stream_waypoint_within(stream, behind);
}

// True when the account of an axis at rest is ahead of this sample, so that nothing can be placed
// in time by the sample any more. The number of idle periods tells.
static inline bool ledger_has_passed(const struct ledger *ledger,
                                     const struct engine_sample *sample)
{
    return (int16_t)(sample->idle_count - ledger->idle_seen) < 0;
}

// Advance the account of time and steps to the sample: pass waypoints, entries and trains of the
// stream, and write a record at each pixel edge on the way. Samples must not go back in time.
void ledger_advance(struct ledger *ledger,
                    struct stream *stream,
                    const struct engine_sample *sample,
                    enum ledger_extent extent);

// All that an advance by waypoints would do without a sample, if the interrupt reads slot `tail`
// next. Returns true when it would do nothing more.
static inline bool ledger_advance_plain(struct ledger *ledger,
                                        struct stream *stream,
                                        uint8_t tail)
{
    return ledger->train == LEDGER_NO_TRAIN &&
           ledger_pass_waypoints(ledger, stream, tail);
}

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

// True when the running and the newest loaded period are idle ones, by an account that was brought
// up to date exactly.
static inline bool ledger_idles(const struct ledger *ledger)
{
    return ledger->train == LEDGER_NO_TRAIN && ledger->fresh == 0 &&
           ledger->lengths[0] == STEP_IDLE_TICKS &&
           ledger->lengths[1] == STEP_IDLE_TICKS && (ledger->pulsed & 3u) == 0;
}

// Start of a period, in ticks since the timers started. back: 0 the newest loaded period (the one
// that the timer makes next), 1 the one before, up to 3, where the account may be a tick off behind
// a train. Divides inside a train.
//
//     period    | back 2        | back 1: running | back 0: loaded |
//     now                               ^
uint32_t ledger_period_start(struct ledger *ledger,
                             const struct stream *stream,
                             uint8_t back);

// The time of an edge that was captured at this count of period `back`. The capture handler's own
// way is longer than the shortest periods, so that more of them may have begun than the handler
// saw: a count that a period does not reach belongs to one before it.
uint32_t ledger_capture_ticks(struct ledger *ledger,
                              const struct stream *stream,
                              uint8_t back,
                              uint16_t captured_ticks);

// Advance to the sample that was taken at a captured edge, and return the edge's time as
// ledger_capture_ticks() does.
uint32_t ledger_advance_to_capture(struct ledger *ledger,
                                   struct stream *stream,
                                   const struct engine_sample *sample,
                                   uint8_t back,
                                   uint16_t captured_ticks);

#if defined(__AVR__) && SEVERAL_AXES
// ledger_advance_to_capture() for every case. ledger_capture.S calls it where its quick way fails.
uint32_t ledger_capture_anywhere(struct ledger *ledger,
                                 struct stream *stream,
                                 const struct engine_sample *sample,
                                 uint8_t back,
                                 uint16_t captured_ticks) __attribute__((used));
#endif

// Position by a sample to which the account was advanced by waypoints: with the single periods that
// the interrupt has made beyond the account. `tail` is the sample's. Of an account that no sample
// may advance now: as far as single periods tell.
int32_t ledger_position_at(const struct ledger *ledger,
                           const struct stream *stream,
                           uint8_t tail);

// Number of steps in ledger_position() whose edge comes after the time `ticks`, which must not be
// older than the period before the running one. edge_ticks: from the start of a period to its STEP
// edge.
uint8_t ledger_steps_after(struct ledger *ledger,
                           const struct stream *stream,
                           uint32_t ticks,
                           uint8_t edge_ticks);

// Take note of the steps made up to here for the play, and return its run (play_settle()).
uint16_t ledger_settle_play(struct ledger *ledger);

// Subtract origin_steps from the position, so that this place becomes position 0.
void ledger_zero(struct ledger *ledger, int32_t origin_steps);

// Nothing more of the stream will be loaded; the stream must be reset afterwards. Position and time
// stay.
void ledger_cut(struct ledger *ledger, const struct stream *stream);
