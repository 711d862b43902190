// SPDX-License-Identifier: MIT
// A line goes through the board's own queue, decoder and ring; a loop in place of the step
// interrupt reads the ring. The decoder is always ahead of that loop, as a board's is.
#include <stdlib.h>

#include "axis/axis.h"
#include "axis/decode.h"
#include "base/require.h"
#include "core.h"

#define QUEUE_BYTES   512u
#define DECODE_BUDGET 64u
#define DELAY_TICKS   1000u
// Of a long wait this much is written into the ring, so that the decoder goes its usual way.
#define WAIT_TICKS (2uL * STEP_PERIOD_MAX_TICKS)
// One call of plan_rows() takes no more periods than this, some 10 ms.
#define PERIODS_AT_ONCE 0x10000u
#define RING_SLOTS      0x100u

// A period passes no more pixel edges than there are marks.
_Static_assert(RECORDS_KEPT >= STREAM_WAYPOINTS,
               "a period passes more pixel edges than are kept");
_Static_assert(PLAN_MIN_ROOM / 2u >= 2u * STREAM_WAYPOINTS,
               "a period makes more rows than fit");

struct plan {
    struct step_ring ring;
    struct pixel_period period;
    struct pixel_grid grid;
    struct line_limits limits;
    struct axis axis;
    uint8_t queue_bytes[QUEUE_BYTES];
    struct step_engine engine;
    const struct segment *entries; // those that are still to be queued
    uint32_t entries_left;
    int64_t *values; // where the next row goes
    int64_t edge_ticks;
    int64_t now_ticks; // start of the period about to be loaded
    int64_t zero_ticks;
    // Time without an edge that passes before the entry in this slot, beside what the ring holds.
    int64_t skipped_ticks[RING_SLOTS];
    uint32_t pixels_shown;
    bool armed;
    bool released;
    bool pixels;
    bool broken;
};

// The core breaks a promise by a mistake of its own, which plan_rows() reports.
static bool promise_broken;

void require_failed(uint16_t line)
{
    (void)line;
    promise_broken = true;
}

// Write the pixel edges that the ledger has recorded since the last call.
static void show_pixels(struct plan *plan)
{
    const struct ledger *ledger = &plan->axis.ledger;

    while (plan->pixels_shown != ledger->pixel) {
        uint32_t behind = ledger->pixel - plan->pixels_shown; // 1: the newest record
        struct pixel_record record =
            records_get(&ledger->records, (uint8_t)(ledger->records.count - behind));

        plan->edge_ticks += pixel_grid_advance(&plan->grid);
        plan->pixels_shown++;
        plan->broken = plan->broken || record.actual_steps != record.expected_steps;
        *plan->values++ = plan->edge_ticks;
        *plan->values++ = record.expected_steps;
    }
}

// Take the empty time that was skipped before the entries up to slot `end`.
static void pass_skipped(struct plan *plan, uint8_t slot, uint8_t end)
{
    for (; slot != end; slot++) {
        plan->now_ticks += plan->skipped_ticks[slot];
        plan->skipped_ticks[slot] = 0;
    }
}

// Load one period as the step interrupt would do.
static void load_period(struct plan *plan)
{
    uint8_t slot = plan->engine.tail;
    struct step_load load = step_engine_next(&plan->engine, &plan->ring);

    pass_skipped(plan, slot, plan->engine.tail);
    if (load.pulse && !plan->pixels) {
        *plan->values++ = plan->now_ticks - plan->zero_ticks;
    }
    plan->now_ticks += (int64_t)load.top_ticks + 1;
    // Halted: the ring was empty inside the line.
    plan->broken = plan->broken || plan->engine.stop;
}

static void follow(struct plan *plan)
{
    struct engine_sample sample = step_engine_sample(&plan->engine);

    ledger_advance(&plan->axis.ledger, &plan->axis.feed.stream, &sample, LEDGER_EXACTLY);
}

static void release(struct plan *plan)
{
    struct feed *feed = &plan->axis.feed;

    plan->zero_ticks = plan->now_ticks + DELAY_TICKS;
    feed_release(feed, feed->lead_in_ticks + DELAY_TICKS);
    axis_place(&plan->axis, (uint32_t)plan->zero_ticks);
    plan->released = axis_released(&plan->axis);
}

static void queue_entry(struct plan *plan, struct segment entry)
{
    struct axis *axis = &plan->axis;
    uint8_t bytes[SEGMENT_MOST] = {(uint8_t)((uint16_t)entry.count >> 8),
                                   (uint8_t)entry.count,
                                   (uint8_t)(entry.repeat >> 8),
                                   (uint8_t)entry.repeat};
    const struct block block = {
        .number = axis->next_block, .bytes = bytes, .size = sizeof bytes};

    if (axis_queue_block(axis, &plan->limits, &block) != BLOCK_TAKEN) {
        plan->broken = true;
    }
}

static void fill_queue(struct plan *plan)
{
    while (plan->entries_left != 0 &&
           segment_queue_free_entries(&plan->axis.queue) != 0) {
        queue_entry(plan, *plan->entries);
        plan->entries++;
        plan->entries_left--;
    }
}

bool plan_over(const struct plan *plan)
{
    return plan->armed && plan->axis.phase == DECODE_OUTSIDE &&
           axis_ring_fill(&plan->axis) == 0;
}

static void arm(struct plan *plan)
{
    (void)lifecycle_report(&plan->axis.life, LIFECYCLE_READY);
    plan->armed = axis_arm(&plan->axis, &plan->period);
    plan->broken = plan->broken || !plan->armed;
}

// Take most of a long wait out of what the decoder still has to write: a pixel at 1 Hz would be
// some 500 periods. The step before the wait must be written first.
static void skip_wait(struct plan *plan)
{
    struct feed *feed = &plan->axis.feed;

    if (!feed->lead && feed->pending_ticks > WAIT_TICKS) {
        plan->skipped_ticks[feed->stream.head] +=
            (int64_t)(feed->pending_ticks - WAIT_TICKS);
        feed->pending_ticks = WAIT_TICKS;
    }
}

// Decode until nothing more can be decoded now.
static void decode_ahead(struct plan *plan)
{
    uint8_t left = 0;

    while (left != DECODE_BUDGET) {
        fill_queue(plan);
        left = decode_axis(&plan->axis, &plan->period, DECODE_BUDGET);
        skip_wait(plan);
    }
}

// Decode, and let the stand-in of the step interrupt take one period.
static void plan_period(struct plan *plan)
{
    if (!plan->armed) {
        fill_queue(plan);
        arm(plan);
    }
    decode_ahead(plan);
    if (!plan->released) {
        release(plan);
    }
    load_period(plan);
    follow(plan);
    if (plan->pixels) {
        show_pixels(plan);
    }
}

int32_t plan_rows(struct plan *plan, int64_t *values, uint32_t room)
{
    const int64_t *end = values + room - PLAN_MIN_ROOM / 2u;
    uint32_t periods = PERIODS_AT_ONCE;

    plan->values = values;
    promise_broken = false;
    while (periods-- != 0 && plan->values < end && !plan->broken && !plan_over(plan)) {
        plan_period(plan);
        plan->broken = plan->broken || promise_broken;
    }
    return plan->broken ? -1 : (int32_t)(plan->values - values);
}

struct plan *plan_begin(uint32_t timer_hz,
                        uint32_t hz_num,
                        uint32_t hz_den,
                        const struct line_limits *limits,
                        const struct segment *entries,
                        uint32_t entry_count,
                        bool pixels)
{
    struct plan *plan = calloc(1, sizeof *plan);

    if (plan == NULL || !pixel_period_set(&plan->period, timer_hz, hz_num, hz_den)) {
        free(plan);
        return NULL;
    }
    plan->limits = *limits;
    plan->entries = entries;
    plan->entries_left = entry_count;
    plan->pixels = pixels;
    pixel_grid_start(&plan->grid, &plan->period);
    step_engine_reset(&plan->engine, &plan->ring);
    const struct axis_parts parts = {
        .ring = &plan->ring,
        .trains = plan->engine.trains,
        .queue_bytes = plan->queue_bytes,
        .queue_size = QUEUE_BYTES,
        .first_period_ticks = STEP_IDLE_TICKS,
    };
    axis_init(&plan->axis, &parts);
    records_thin(1, UINT16_MAX);
    plan->axis.feed.reversal_ticks = plan->limits.reversal_min_ticks / 2u;
    plan->now_ticks = STEP_IDLE_TICKS;
    return plan;
}

void plan_end(struct plan *plan)
{
    free(plan);
}
