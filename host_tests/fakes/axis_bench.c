// SPDX-License-Identifier: MIT
#include "fakes/axis_bench.h"

#include <string.h>

#include "axis/decode.h"          // decode_*
#include "fakes/worked_example.h" // worked_entry

#define TIMER_HZ 16000000uL
#define BUDGET   64u

struct axis_bench bench;

static uint8_t budget(void)
{
    return bench.budget != 0 ? bench.budget : BUDGET;
}

void bench_open(uint32_t hz_num, uint32_t hz_den)
{
    bench = (struct axis_bench){.now_ticks = 2uL * STEP_IDLE_TICKS, .divider = 1};
    (void)pixel_period_set(&bench.period, TIMER_HZ, hz_num, hz_den);
    bench.limits = (struct line_limits){
        .pixel_ticks = bench.period.whole_ticks,
#if FEATURE_LINE_DIVIDER
        .divider = 1,
#endif
        .min_interval_ticks = 64,
        .smooth_min_interval_ticks = 64,
        .reversal_min_ticks = 1664,
    };
    step_engine_reset(&bench.engine, &bench.ring);
    const struct axis_parts parts = {
        .ring = &bench.ring,
        .trains = bench.engine.trains,
        .queue_bytes = bench.queue_bytes,
        .queue_size = sizeof bench.queue_bytes,
        .first_period_ticks = STEP_IDLE_TICKS,
    };
    axis_init(&bench.axis, &parts);
    records_thin(1, UINT16_MAX);
}

void bench_stagger(uint8_t steps)
{
#if SEVERAL_AXES
    bench.axis.stagger = steps & 15u;
#else
    (void)steps;
#endif
}

// The limits with the divider that a block brings, as app makes them.
static struct line_limits limits_for(const struct block *block)
{
    struct line_limits limits = bench.limits;

#if FEATURE_LINE_DIVIDER
    uint16_t edges = axis_block_divider(&bench.axis, block);
    if (edges != 0 && bench.divider != 0) {
        limits.divider = edges;
        limits.pixel_ticks = bench.period.whole_ticks * edges;
    }
#else
    (void)block;
#endif
    return limits;
}

enum block_result bench_queue_block(uint16_t number,
                                    const uint8_t *bytes,
                                    uint8_t size,
                                    bool packed)
{
    static uint8_t copy[BENCH_BLOCK_MAX];
    const struct block block = {
        .number = number, .bytes = copy, .size = size, .packed = packed};

    memcpy(copy, bytes, size);
    struct line_limits limits = limits_for(&block);
    enum block_result result = axis_queue_block(&bench.axis, &limits, &block);
#if FEATURE_LINE_DIVIDER
    if (result == BLOCK_TAKEN && bench.divider != 0) {
        bench.limits = limits;
        bench.divider = limits.divider;
    }
#endif
    return result;
}

enum block_result bench_queue(int16_t count, uint16_t repeat)
{
    uint16_t word = (uint16_t)count;
    uint8_t bytes[4] = {
        (uint8_t)(word >> 8),
        (uint8_t)word,
        (uint8_t)(repeat >> 8),
        (uint8_t)repeat,
    };

    return bench_queue_block(bench.axis.next_block, bytes, sizeof bytes, false);
}

bool bench_queue_run(int16_t mark, int16_t count, uint16_t pixels)
{
    return bench_queue(mark, 0) == BLOCK_TAKEN && bench_queue(0, 0) == BLOCK_TAKEN &&
           bench_queue(count, pixels) == BLOCK_TAKEN &&
           bench_queue(LINE_MARK_END, 0) == BLOCK_TAKEN;
}

bool bench_queue_worked_example(uint16_t backlash_steps)
{
    struct segment entry;

    for (uint8_t i = 0; worked_entry(backlash_steps, i, &entry); i++) {
        if (bench_queue(entry.count, entry.repeat) != BLOCK_TAKEN) {
            return false;
        }
    }
    return true;
}

bool bench_start_line(void)
{
    struct axis *axis = &bench.axis;

    if (!axis_arm(axis, &bench.period)) {
        return false;
    }
    while (!decode_is_ahead(axis)) {
        decode_axis(axis, &bench.period, budget());
    }
    bench.zero_ticks = bench.now_ticks + BENCH_DELAY_TICKS;
    feed_release(&axis->feed, axis->feed.lead_in_ticks + BENCH_DELAY_TICKS);
    axis_place(axis, bench.zero_ticks);
    return axis_released(axis);
}

struct step_load bench_period(void)
{
    struct step_load load;

    decode_axis(&bench.axis, &bench.period, budget());
    load = step_engine_next(&bench.engine, &bench.ring);
    struct engine_sample sample = step_engine_sample(&bench.engine);
    ledger_advance(&bench.axis.ledger, &bench.axis.feed.stream, &sample, LEDGER_EXACTLY);
    if (load.pulse) {
        bench.steps += bench.engine.negative ? -1 : 1;
    }
    bench.now_ticks += (uint32_t)load.top_ticks + 1u;
    return load;
}

bool bench_finish_line(void)
{
    struct axis *axis = &bench.axis;

    if (axis->life.state != AXIS_RUNNING || axis->phase != DECODE_OUTSIDE ||
        axis_ring_fill(axis) != 0 || bench.engine.state != STEP_ENGINE_IDLE) {
        return false;
    }
    axis_line_finished(axis);
    return true;
}
