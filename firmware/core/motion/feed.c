// SPDX-License-Identifier: MIT
#include "motion/feed.h"

#include <stddef.h> // NULL

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

void feed_reset(struct feed *feed, struct step_ring *ring, uint8_t head)
{
    *feed = (struct feed){
        .ring = ring,
        .engine_trains = feed->engine_trains,
        .reversal_ticks = feed->reversal_ticks,
        .head = head,
        .negative = feed->negative,
    };
    ring->high[head] = STEP_HIGH_EMPTY;
}

static inline void put_period(struct feed *feed, uint16_t ticks)
{
    feed->head = feed_burst_put(feed->ring, feed->head, ticks);
}

static void put_command(struct feed *feed, enum step_command command)
{
    // A command is stored like a period whose high byte says so.
    put_period(feed,
               (uint16_t)(((uint16_t)STEP_HIGH_COMMAND << 8 | (uint8_t)command) + 1u));
}

// Give every waiting mark its place, `early` periods before the end of what is written.
static void place_marks(struct feed *feed, uint8_t early)
{
    while (feed->mark_placed != feed->mark_head) {
        struct feed_mark *mark = &feed->marks[feed->mark_placed & (FEED_MARKS - 1u)];
        mark->slot = feed->head;
        mark->early = early & 0x7Fu;
        feed->mark_placed++;
    }
}

// Write one period. Marks that waited for the period that carries the lead's STEP edge are placed
// behind that period.
static void put_chunk(struct feed *feed, uint16_t ticks)
{
    if (feed->pulse != feed->lead) {
        put_command(feed, feed->lead ? STEP_COMMAND_PULSE : STEP_COMMAND_QUIET);
        feed->pulse = feed->lead;
    }
    put_period(feed, ticks);
    feed->lead = false;
    feed->pending_ticks -= ticks;
    feed->written_ticks += ticks;
    feed->merge = false;
    place_marks(feed, 0);
}

bool feed_fits_train(const struct feed *feed, const struct even *even)
{
    return feed->engine_trains != NULL && even->base_ticks < STEP_PERIOD_MAX_TICKS &&
           (even->remainder == 0 || ((uint8_t)even->base_ticks != 0));
}

// Write one entry of a pulse train; the sign of its number of steps tells which train.
static void put_train(struct feed *feed, uint8_t train, uint8_t steps)
{
    uint8_t slot = feed->head;
    uint8_t next = (uint8_t)(slot + 1u);

    feed->ring->high[next] = STEP_HIGH_EMPTY;
    feed->ring->low[slot] = train == 0 ? steps : (uint8_t)-steps;
    feed->ring->high[slot] = STEP_HIGH_TRAIN;
    feed->head = next;
}

static void fill_train(struct pulse_train *train, const struct even *even)
{
    uint16_t top = (uint16_t)(even->base_ticks - 1u);
    int16_t after_long = (int16_t)(even->remainder - even->steps);

    train->after_short = (int16_t)even->remainder;
    train->after_long = after_long;
    train->sum = (int16_t)(even->sum + (uint16_t)after_long);
    train->short_low = (uint8_t)top;
    train->long_low = (uint8_t)(top + 1u);
    train->top_high = (uint8_t)(top >> 8);
}

void feed_train(struct feed *feed,
                const struct even *even,
                uint16_t steps,
                uint32_t ticks)
{
    uint8_t train = feed->trains[0].steps == 0 ? 0 : 1;

    REQUIRE(feed->trains[train].steps == 0);
    fill_train(&feed->engine_trains[train], even);
    feed->trains[train] = (struct feed_train){steps, even->sum, ticks};
    feed->newest_train = train;
    if (!feed->pulse) {
        put_command(feed, STEP_COMMAND_PULSE);
        feed->pulse = true;
    }
    while (steps != 0) {
        uint16_t now = steps > STEP_TRAIN_ENTRY_MAX ? STEP_TRAIN_ENTRY_MAX : steps;
        put_train(feed, train, (uint8_t)now);
        // Waiting marks belong behind the step before the train. The train's first period carries
        // the edge of that step, so that the marks come right behind that period.
        place_marks(feed, (uint8_t)(now - 1u));
        steps = (uint16_t)(steps - now);
    }
    feed->written_ticks += ticks;
}

uint32_t feed_train_ticks(const struct feed *feed, uint8_t train, uint16_t index)
{
    const struct pulse_train *carried = &feed->engine_trains[train];
    struct even even = {
        .base_ticks = feed_train_base(feed, train),
        .remainder = (uint16_t)carried->after_short,
        .steps = (uint16_t)(carried->after_short - carried->after_long),
        .sum = feed->trains[train].sum,
    };

    return even_skip(&even, index);
}

void feed_hold(struct feed *feed)
{
    feed->held = true;
    feed->merge = true;
    feed->lead_in_ticks = 0;
    feed->held_slot = feed->head;
    // The held slot keeps its empty mark: everything behind it is invisible to the interrupt.
    feed->head = (uint8_t)(feed->head + HELD_SLOTS);
    feed->ring->high[feed->head] = STEP_HIGH_EMPTY;
}

static void put_held(struct feed *feed, uint8_t offset, uint32_t ticks)
{
    uint8_t slot = (uint8_t)(feed->held_slot + offset);
    uint16_t top = (uint16_t)(ticks - 1u);

    feed->ring->low[slot] = (uint8_t)top;
    feed->ring->high[slot] = (uint8_t)(top >> 8);
}

void feed_fill_front(struct feed *feed, uint32_t delay_ticks)
{
    uint32_t half = delay_ticks / 2u;

    REQUIRE(feed->held && half != 0 && delay_ticks <= FEED_DELAY_MAX_TICKS);
    put_held(feed, 1, half);
    put_held(feed, 2, delay_ticks - half);
    feed->ring->low[feed->held_slot] = STEP_COMMAND_BEGIN;
}

void feed_front_released(struct feed *feed, uint32_t delay_ticks)
{
    feed->written_ticks += delay_ticks;
    feed->held = false;
    feed->merge = false;
}

void feed_release(struct feed *feed, uint32_t delay_ticks)
{
    feed_fill_front(feed, delay_ticks);
    feed_publish_front(feed);
    feed_front_released(feed, delay_ticks);
}

// Write an interval with a reversal: the direction changes in the middle of the interval, inside a
// period that does not pulse.
static void put_reversal(struct feed *feed)
{
    if (feed->lead) {
        put_chunk(feed, (uint16_t)(feed->pending_ticks / 2u));
    }
    if (feed->pending_ticks != 0) {
        put_chunk(feed, (uint16_t)feed->pending_ticks);
    }
    put_command(feed, feed->due_negative ? STEP_COMMAND_NEGATIVE : STEP_COMMAND_POSITIVE);
    feed->negative = feed->due_negative;
}

// Leave the first interval of a line to the delay before the line, if the interval is short enough.
static void merge_first_interval(struct feed *feed)
{
    if (feed->merge && feed->pending_ticks <= MERGE_MAX_TICKS) {
        feed->lead_in_ticks = feed->pending_ticks;
        feed->pending_ticks = 0;
    }
    feed->merge = false;
}

void feed_make_room(struct feed *feed)
{
    if (!feed_marks_full(feed)) {
        return;
    }
    feed->merge = false;
    // A reversal may follow, with this period before the change of direction and the time that is
    // left behind it. The period is therefore no shorter than that time.
    if (feed->pending_ticks >= 2u * (uint32_t)feed->reversal_ticks + ROOM_MIN_TICKS) {
        put_chunk(feed, (uint16_t)(feed->pending_ticks - feed->reversal_ticks));
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
    if (feed->due_negative != feed->negative) {
        put_reversal(feed);
    } else if (feed->pending_ticks != 0) {
        put_chunk(feed, (uint16_t)feed->pending_ticks);
    }
    place_marks(feed, 0);
    feed->lead = true;
    feed->step_due = false;
}

void feed_step(struct feed *feed, uint32_t interval_ticks, bool negative)
{
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

void feed_mark_here(struct feed *feed, bool line_start, int32_t position)
{
    struct feed_mark *mark = &feed->marks[feed->mark_head & (FEED_MARKS - 1u)];

    mark->line_start = line_start;
    mark->position = (uint16_t)position;
    feed->mark_head++;
    if (!feed->lead) {
        place_marks(feed, 0);
    }
}

void feed_end(struct feed *feed)
{
    REQUIRE(!feed_busy(feed));
    if (feed->lead || feed->pending_ticks != 0) {
        // The last step needs a period of its own for its edge, however little time is left.
        if (feed->pending_ticks < STEP_IDLE_TICKS) {
            feed->pending_ticks = STEP_IDLE_TICKS;
        }
        put_chunk(feed, (uint16_t)feed->pending_ticks);
    }
    place_marks(feed, 0);
    put_command(feed, STEP_COMMAND_END);
    feed->pulse = false;
}
