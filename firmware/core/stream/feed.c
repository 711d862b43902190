// SPDX-License-Identifier: MIT
#include "stream/feed.h"

#include "base/apart.h"   // APART
#include "base/require.h" // REQUIRE

// A long interval is cut into periods of this length, ticks. The last period is then at least
// STEP_PERIOD_MAX_TICKS - CHUNK_TICKS long, which leaves time for the commands around it.
#define CHUNK_TICKS 0x8000u
// Slots at the front of a held line: its begin command and two periods of the delay.
#define HELD_SLOTS 3u
// Longest first interval of a line that is merged into the delay before it, ticks.
#define MERGE_MAX_TICKS 0x7000u
// Shortest period that is made of waiting time alone, ticks: the commands around a period need this
// much time.
#define ROOM_MIN_TICKS 1024u

void feed_reset(struct feed *feed, uint8_t slot, bool negative, uint32_t end_ticks)
{
    feed->pulse = false;
    feed->negative = negative;
    feed->lead = false;
    feed->step_due = false;
    feed->held = false;
    feed->merge = false;
    feed->lead_in_ticks = 0;
    feed->pending_ticks = 0;
    stream_reset(&feed->stream, slot, end_ticks);
}

// Write one period. Marks that waited for the period that carries the lead's STEP edge are placed
// behind that period.
static void put_chunk(struct feed *feed, uint16_t ticks)
{
    if (feed->pulse != feed->lead) {
        stream_put_command(&feed->stream,
                           feed->lead ? STEP_COMMAND_PULSE : STEP_COMMAND_QUIET);
        feed->pulse = feed->lead;
    }
    stream_put_period(&feed->stream, ticks);
    feed->lead = false;
    feed->pending_ticks -= ticks;
    feed->merge = false;
}

uint32_t feed_train(struct feed *feed, struct even *even, uint16_t steps)
{
    BY_POINTER_SMALL(feed);
    if (!feed->pulse) {
        stream_put_command(&feed->stream, STEP_COMMAND_PULSE);
        feed->pulse = true;
    }
    return stream_put_train(&feed->stream, even, steps);
}

APART void feed_hold(struct feed *feed)
{
    feed->held = true;
    feed->merge = true;
    feed->lead_in_ticks = 0;
    feed->held_slot = stream_reserve(&feed->stream, HELD_SLOTS);
}

static APART void put_held(struct step_ring *ring, uint8_t slot, uint32_t ticks)
{
    uint16_t top = (uint16_t)((uint16_t)ticks - 1u);

    ring->low[slot] = (uint8_t)top;
    ring->high[slot] = (uint8_t)(top >> 8);
}

void feed_fill_front(struct feed *feed, uint32_t delay_ticks)
{
    BY_POINTER_SMALL(feed);
    struct step_ring *ring = feed->stream.ring;
    uint8_t slot = feed->held_slot;
    uint32_t half = delay_ticks / 2u;

    REQUIRE(feed->held && half != 0 && delay_ticks <= FEED_DELAY_MAX_TICKS);
    put_held(ring, (uint8_t)(slot + 1u), half);
    put_held(ring, (uint8_t)(slot + 2u), delay_ticks - half);
    ring->low[slot] = STEP_COMMAND_BEGIN;
}

void feed_front_released(struct feed *feed, uint32_t delay_ticks)
{
    stream_delay(&feed->stream, delay_ticks);
    feed->held = false;
    feed->merge = false;
}

void feed_release(struct feed *feed, uint32_t delay_ticks)
{
    feed_fill_front(feed, delay_ticks);
    feed_publish_front(feed);
    feed_front_released(feed, delay_ticks);
}

// Write the interval up to the step that is due. At a reversal the direction changes in the middle
// of the interval, inside a period that does not pulse.
static void put_interval(struct feed *feed)
{
    bool reverses = feed->due_negative != feed->negative;

    // What is pending fits 16 bits.
    if (reverses && feed->lead) {
        put_chunk(feed, (uint16_t)feed->pending_ticks / 2u);
    }
    if ((uint16_t)feed->pending_ticks != 0) {
        put_chunk(feed, (uint16_t)feed->pending_ticks);
    }
    if (reverses) {
        feed->negative = feed->due_negative;
        stream_put_command(&feed->stream,
                           feed->negative ? STEP_COMMAND_NEGATIVE
                                          : STEP_COMMAND_POSITIVE);
    }
}

// Leave the first interval of a line to the delay before the line, if the interval is short enough.
// What is pending fits 16 bits.
static void merge_first_interval(struct feed *feed)
{
    if (feed->merge && (uint16_t)feed->pending_ticks <= MERGE_MAX_TICKS) {
        feed->lead_in_ticks = feed->pending_ticks;
        feed->pending_ticks = 0;
    }
    feed->merge = false;
}

APART_LARGE void feed_make_room(struct feed *feed, bool waits)
{
    BY_POINTER_SMALL(feed);
    if (!waits && !stream_waypoints_full(&feed->stream)) {
        return;
    }
    feed->merge = false;
    // A reversal may follow, with the last period before the change of direction and the time that
    // is left behind it.
    for (;;) {
        uint16_t half_ticks = (uint16_t)(feed->pending_ticks / 2u);

        if (half_ticks < (uint16_t)(feed->reversal_ticks + ROOM_MIN_TICKS)) {
            return;
        }
        put_chunk(feed, half_ticks);
    }
}

void feed_pump(struct feed *feed)
{
    if (feed->pending_ticks > STEP_PERIOD_MAX_TICKS) {
        put_chunk(feed, CHUNK_TICKS);
        return;
    }
    if (!feed->step_due) {
        return;
    }
    merge_first_interval(feed);
    put_interval(feed);
    stream_place_waypoints(&feed->stream, 0);
    feed->lead = true;
    feed->step_due = false;
}

void feed_step(struct feed *feed, uint32_t interval_ticks, bool negative)
{
    BY_POINTER_SMALL(feed);
    REQUIRE(!feed_busy(feed));
    feed->pending_ticks += interval_ticks;
    feed->step_due = true;
    feed->due_negative = negative;
    feed_pump(feed);
}

void feed_quiet(struct feed *feed, uint32_t ticks)
{
    feed->pending_ticks += ticks;
    feed_pump(feed);
}

void feed_mark_here(struct feed *feed, bool line_start, int16_t position)
{
    BY_POINTER_SMALL(feed);
    stream_add_waypoint(&feed->stream, line_start, (uint16_t)position);
    if (!feed->lead) {
        stream_place_waypoints(&feed->stream, 0);
    }
}

APART void feed_end(struct feed *feed)
{
    REQUIRE(!feed_busy(feed));
    if (feed->lead || feed->pending_ticks != 0) {
        // The last step needs a period of its own for its edge, however little time is left.
        if (feed->pending_ticks < STEP_IDLE_TICKS) {
            feed->pending_ticks = STEP_IDLE_TICKS;
        }
        put_chunk(feed, (uint16_t)feed->pending_ticks);
    }
    stream_place_waypoints(&feed->stream, 0);
    stream_put_command(&feed->stream, STEP_COMMAND_END);
    feed->pulse = false;
}
