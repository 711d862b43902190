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
// A line is decoded ahead after a held slot: the ring looks empty to the interrupt until
// feed_release() fills that slot and the delay after it.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "stream/even.h"   // struct even
#include "stream/stream.h" // struct stream

// The writers of whole pixels and of batches append to `stream` directly, where feed_plain() or
// feed_steady() allows it. Otherwise modules read the members and write by the functions below.
struct feed {
    // Shortest time from a change of direction to the next step, ticks; app/axes/limits.c sets it.
    uint16_t reversal_ticks;
    // Periods that are appended now pulse: the last command of that kind was STEP_COMMAND_PULSE.
    bool pulse;
    // Direction of the newest written step; before the first step, of the steps made before.
    bool negative;
    // The next period begins with a STEP edge: the newest step still lacks its period.
    bool lead;
    // A step comes at the end of pending_ticks.
    bool step_due;
    // Direction of that step.
    bool due_negative;
    // The front of the line is not released yet.
    bool held;
    // The next interval, the first one of a held line, may be merged into the delay before the
    // line.
    bool merge;
    // The slot that hides the front while `held` is set.
    uint8_t held_slot;
    // Length of the first interval, ticks, if it was merged: the delay must cover it. Else 0.
    uint32_t lead_in_ticks;
    // Time that is decoded but not written, ticks. Zero pixels add to it.
    uint32_t pending_ticks;
    // What is written. Its reader's end belongs to the ledger.
    struct stream stream;
};

// Discard what is not made: an empty stream whose both ends are at `slot`. Keeps the reversal time.
// negative: direction of the steps made so far. slot, end_ticks: see stream_reset().
void feed_reset(struct feed *feed, uint8_t slot, bool negative, uint32_t end_ticks);

// Most entries that one call of the functions below writes.
#define FEED_BURST 8u

// Longest delay of feed_release(), ticks.
#define FEED_DELAY_MAX_TICKS (2uL * STEP_PERIOD_MAX_TICKS)

// Reserve the held front, three slots: its begin command and two delay periods. The line's
// intervals follow. The ring reads empty to the interrupt until feed_release(). Only for an axis at
// rest, whose stream is empty.
void feed_hold(struct feed *feed);

// Publish the held front so that the line begins after delay_ticks (2..FEED_DELAY_MAX_TICKS,
// lead_in_ticks included). The delay becomes two periods of about half of it each; a front that is
// not held, or a delay outside the range, breaks a promise (REQUIRE). Called where the step
// interrupt cannot load another idle period meanwhile.
//
//     slots    | BEGIN | half | half | the line's periods ...
//              ^ held_slot, empty to the interrupt until its high byte is stored
void feed_release(struct feed *feed, uint32_t delay_ticks);
// feed_release() in three parts, of which only the second must not be interrupted. First: fill the
// front, which stays invisible. May be repeated with another delay.
void feed_fill_front(struct feed *feed, uint32_t delay_ticks);
// Second: the single store that publishes the front, at the instant that the delay was made for.
static inline void feed_publish_front(struct feed *feed)
{
    feed->stream.ring->high[feed->held_slot] = STEP_HIGH_COMMAND;
}
// Third: account for the front, after the store, with the delay that feed_fill_front() had last.
void feed_front_released(struct feed *feed, uint32_t delay_ticks);

// Add interval_ticks and then a step in this direction; at a reversal the change of direction comes
// in the middle. Only when feed_busy() is false, else a promise is broken. The feed may be busy
// afterwards, so that feed_pump() must write the rest. Writes FEED_BURST entries at most.
void feed_step(struct feed *feed, uint32_t interval_ticks, bool negative);

// True when each step in this direction needs nothing but one period: the newest step lacks its
// period, nothing else is pending, and no waypoint waits. stream_space() periods of up to
// STEP_PERIOD_MAX_TICKS may then be appended as a batch instead of by feed_step().
static inline bool feed_plain(const struct feed *feed, bool negative)
{
    return feed->lead && feed->pulse && feed->pending_ticks == 0 &&
           negative == feed->negative && !stream_waypoint_waits(&feed->stream);
}

// True when steps in this direction may be handed over as a pulse train: as feed_plain(), but
// waypoints may wait and a command may be needed first.
static inline bool feed_steady(const struct feed *feed, bool negative)
{
    return feed->lead && feed->pending_ticks == 0 && negative == feed->negative;
}

// Hand over the next `steps` of evenly spaced steps as a pulse train, and pass them in *even. Only
// when feed_steady(), stream_train_free() and stream_fits_train(). Returns the train's ticks.
uint32_t feed_train(struct feed *feed, struct even *even, uint16_t steps);

// Add `ticks` of time without a step at its end, as a zero pixel does. Only when feed_busy() is
// false. Writes one entry or two, or none while the time still fits one period.
void feed_quiet(struct feed *feed, uint32_t ticks);

// Write pending time, and the step if one is due, FEED_BURST entries at most. To be called again
// and again while feed_busy(), with that much room in the ring each time.
void feed_pump(struct feed *feed);

// To be called after a pixel edge was placed. waits: what follows must wait for the pixel clock.
// Time of zero pixels is kept unwritten until a step follows it. This must not be where the decoder
// cannot go on, because the waypoint was the last that fits or because of the clock. Then all of
// the time except what a reversal needs becomes periods of its own.
void feed_make_room(struct feed *feed, bool waits);

// True when time or a step is pending that feed_pump() must write first; feed_step() and feed_end()
// must wait until then.
static inline bool feed_busy(const struct feed *feed)
{
    return feed->step_due || feed->pending_ticks > STEP_PERIOD_MAX_TICKS;
}

// Place a pixel edge or a line start after everything fed so far. The waypoint waits for the period
// that carries the newest step's STEP edge, if that period is still to be written. position:
// expected position at the edge, signed steps of the line. Only when stream_waypoints_full() is
// false.
void feed_mark_here(struct feed *feed, bool line_start, int16_t position);

// The line is over, and nothing follows it without a gap: write the last step's period, which is at
// least STEP_IDLE_TICKS long, and the end command. Only when feed_busy() is false, else a promise
// is broken.
void feed_end(struct feed *feed);
