// SPDX-License-Identifier: MIT
// The writer's end of an axis's stream: intervals in, timer periods and commands out. Main loop
// only.
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
// to the interrupt until feed_release() fills that slot and the delay after it.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "stream/even.h"   // struct even
#include "stream/stream.h" // struct stream

// Other modules read the members; they write by the functions below alone.
struct feed {
    // Shortest time from a change of direction to the next step, ticks; app/axes/limits.c sets it.
    uint16_t reversal_ticks;
    bool pulse;    // the entries written so far end with a period that pulses
    bool negative; // direction of the newest written step
    // The next period begins with a STEP edge.
    bool lead;
    // A step comes at the end of pending_ticks.
    bool step_due;
    // Direction of that step.
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
    // What is written. Its reader's end belongs to the ledger.
    struct stream stream;
};

// Discard what is not made: an empty stream whose both ends are at `slot`. Keeps the reversal time.
// negative: direction of the steps made so far; end_ticks: see stream_reset().
void feed_reset(struct feed *feed, uint8_t slot, bool negative, uint32_t end_ticks);

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
    feed->stream.ring->high[feed->held_slot] = STEP_HIGH_COMMAND;
}
// third: account for the front, after the store.
void feed_front_released(struct feed *feed, uint32_t delay_ticks);

// Add interval_ticks and then a step in this direction. Only when feed_busy() is false; the feed
// may be busy afterwards, so that feed_pump() must write the rest.
void feed_step(struct feed *feed, uint32_t interval_ticks, bool negative);

// True when each step in this direction needs nothing but one period. stream_space() periods of up
// to STEP_PERIOD_MAX_TICKS may then be appended as a batch instead of by feed_step().
static inline bool feed_plain(const struct feed *feed, bool negative)
{
    return feed->lead && feed->pulse && feed->pending_ticks == 0 &&
           negative == feed->negative && !stream_waypoint_waits(&feed->stream);
}

// True when steps in this direction may be handed over as a pulse train.
static inline bool feed_steady(const struct feed *feed, bool negative)
{
    return feed->lead && feed->pending_ticks == 0 && negative == feed->negative;
}

// Hand over the next `steps` of evenly spaced steps as a pulse train, and pass them in *even. Only
// when feed_steady(), stream_train_free() and stream_fits_train(). Returns the train's ticks.
uint32_t feed_train(struct feed *feed, struct even *even, uint16_t steps);

// Add time without a step at its end. Only when feed_busy() is false.
void feed_quiet(struct feed *feed, uint32_t ticks);

// Write pending time, FEED_BURST entries at most. Call it while feed_busy() and while there is
// space.
void feed_pump(struct feed *feed);

// After a waypoint. When the waypoint was the last that fits, or when what follows must wait for
// the clock, the time of zero pixels that is not written yet must not wait for more of them: all of
// it except what a reversal needs becomes periods of its own.
void feed_make_room(struct feed *feed, bool waits);

// True when time or a step is pending that feed_pump() must write first; feed_step() and feed_end()
// must wait until then.
static inline bool feed_busy(const struct feed *feed)
{
    return feed->step_due || feed->pending_ticks > STEP_PERIOD_MAX_TICKS;
}

// Place a pixel edge or a line start behind everything fed so far. position: expected position at
// the edge, signed steps of the line. Only when stream_waypoints_full() is false.
void feed_mark_here(struct feed *feed, bool line_start, int16_t position);

// The line is over, and nothing follows it without a gap: write the last step's period and the end
// command. Only when feed_busy() is false.
void feed_end(struct feed *feed);
