// SPDX-License-Identifier: MIT
// The reader's end of an axis's stream: the account of what the step interrupt made of the stream,
// that is time, position and pixel edges. The position is what was handed to the timer, never what
// was only written; a step counts when its period is loaded, at most one period before its edge.
// Axes ask the account for positions, the clock's and the switch's captured edges are placed in
// time by it, and the decoder learns from it which slots are free. Main loop only.
//
//     stream     | retired ...            tail |  ...       head |
//                |<-- made, not accounted for ->|<-- decoded --->|
//
// ledger_advance() and the functions made of its parts move the account: from waypoint to waypoint
// where single periods alone stand between, and else entry by entry, up to the interrupt's `tail`.
//
// The account must be advanced before the ring is full, so that the decoder has slots, and before
// 65536 idle periods pass beside it, because their number wraps (ledger_has_passed(): 32768).
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "account/ledger_data.h"      // struct ledger
#include "account/ledger_waypoints.h" // ledger_pass_waypoints
#include "build_features.h"           // SEVERAL_AXES
#include "ring/step_engine.h"         // struct engine_sample
#include "stream/stream.h"            // struct stream

// Entries of a pulse train that may wait to be accounted for: with this many ledger_due() is true.
#define LEDGER_LAG_ENTRIES 8u

// A new account at position 0, with no records. first_period_ticks: length of each of the two
// periods that the timers hold when they start (the interrupt at the end of the first one loads the
// third).
void ledger_reset(struct ledger *ledger, uint16_t first_period_ticks);

// The timers were started again: time begins at 0, and the engine counts idle periods from 0.
// Position, direction, play and records stay. The stream must be reset afterwards. The axis must be
// at rest, and the account must have come to the last step before.
void ledger_restart(struct ledger *ledger, uint16_t first_period_ticks);

// How far ledger_advance() goes.
enum ledger_extent {
    // To the sample.
    LEDGER_EXACTLY,
    // To the sample, except for single periods that lead to a waypoint: the waypoint passes them
    // later, at a much lower cost. Idle periods and a cut make the advance exact.
    LEDGER_BY_WAYPOINTS,
};

// False when an advance by waypoints to this sample would do nothing, or would only count periods
// of a train that continues: that can wait until somebody asks for the position. Changes nothing.
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
// in time by the sample any more. The number of idle periods tells, as long as the two are less
// than 32768 idle periods apart.
static inline bool ledger_has_passed(const struct ledger *ledger,
                                     const struct engine_sample *sample)
{
    return (int16_t)(sample->idle_count - ledger->idle_seen) < 0;
}

// Advance the account of time and steps to the sample: pass waypoints, entries and trains of the
// stream, and write a record at each pixel edge on the way. Idle periods are accounted for at once,
// however many. A sample whose train was cut ends the account of that train, and the waypoints that
// were still to come are forgotten. Samples must not go back in time. The time that this takes
// grows with the entries since the last call.
void ledger_advance(struct ledger *ledger,
                    struct stream *stream,
                    const struct engine_sample *sample,
                    enum ledger_extent extent);

// The part of an advance by waypoints that needs no sample, only the slot `tail` that the interrupt
// reads next. Returns true when the whole advance would do no more than that.
static inline bool ledger_advance_plain(struct ledger *ledger,
                                        struct stream *stream,
                                        uint8_t tail)
{
    return ledger->train == LEDGER_NO_TRAIN &&
           ledger_pass_waypoints(ledger, stream, tail);
}

// Position of the axis: signed steps since reset, or since ledger_zero(). Steps count whose periods
// were loaded by the time of the sample that the account has come to.
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

// True when the running and the newest loaded period are idle ones. Only where the account was
// advanced exactly to a sample: the answer is of that sample.
static inline bool ledger_idles(const struct ledger *ledger)
{
    return ledger->train == LEDGER_NO_TRAIN && ledger->fresh == 0 &&
           ledger->lengths[0] == STEP_IDLE_TICKS &&
           ledger->lengths[1] == STEP_IDLE_TICKS && (ledger->pulsed & 3u) == 0;
}

// Start of a period, in ticks since the timers started; wraps. back: 0 the newest loaded period
// (which the timer makes next), 1 the one before, up to 3. With 3, the result may be a tick off
// after a train. The account must have come exactly to the sample that `back` counts from. Divides
// inside a train.
//
//     period    | back 2        | back 1: running | back 0: loaded |
//     now                               ^
uint32_t ledger_period_start(struct ledger *ledger,
                             const struct stream *stream,
                             uint8_t back);

// The time of an edge that was captured at count captured_ticks of period `back`, ticks since the
// timers started; wraps. The handler takes longer than the shortest periods to begin, so that more
// periods may have begun than it saw: a count that a period does not reach belongs to a period
// before. Needs what ledger_period_start() needs.
uint32_t ledger_capture_ticks(struct ledger *ledger,
                              const struct stream *stream,
                              uint8_t back,
                              uint16_t captured_ticks);

// Advance to the sample that was taken at a captured edge, by waypoints or exactly as the case
// needs, and return the edge's time as ledger_capture_ticks() does. `back` and captured_ticks: as
// the capture's handler noted them (ring/captured_edge.h).
uint32_t ledger_advance_to_capture(struct ledger *ledger,
                                   struct stream *stream,
                                   const struct engine_sample *sample,
                                   uint8_t back,
                                   uint16_t captured_ticks);

#if defined(__AVR__) && SEVERAL_AXES
// ledger_advance_to_capture() for every case. There ledger_advance_to_capture() itself is assembly,
// ledger_capture.S, which calls this function where its quick way fails.
uint32_t ledger_capture_anywhere(struct ledger *ledger,
                                 struct stream *stream,
                                 const struct engine_sample *sample,
                                 uint8_t back,
                                 uint16_t captured_ticks) __attribute__((used));
#endif

// Position by a sample to which the account was advanced by waypoints: ledger_position(), and the
// single periods that the interrupt has made beyond the account. tail: the sample's. Where no
// sample may advance the account now, the result counts single periods up to the next entry of
// another kind. Changes nothing.
int32_t ledger_position_at(const struct ledger *ledger,
                           const struct stream *stream,
                           uint8_t tail);

// Number of steps, 0..3, in ledger_position() whose edge comes after the time `ticks`. That time
// must not be older than the period before the running one. edge_ticks: from the start of a period
// to its STEP edge. The account must have come exactly to its sample. Divides inside a train.
uint8_t ledger_steps_after(struct ledger *ledger,
                           const struct stream *stream,
                           uint32_t ticks,
                           uint8_t edge_ticks);

// Take note of the steps made up to here for the play, and return its run (play_settle()), steps.
// Periods of a train that are not loaded yet do not count: they may still be cut off.
uint16_t ledger_settle_play(struct ledger *ledger);

// Subtract origin_steps from the position, so that the place with that position becomes position 0.
// Records of the line keep their values, because they count from the line's start.
void ledger_zero(struct ledger *ledger, int32_t origin_steps);

// Nothing more of the stream will be loaded; the stream must be reset afterwards. Position and time
// stay. The account must have come to the halted engine's sample, so that a train is closed.
void ledger_cut(struct ledger *ledger, const struct stream *stream);
