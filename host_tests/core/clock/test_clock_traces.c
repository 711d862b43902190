// SPDX-License-Identifier: MIT
// Edges of the pixel clock at every limit, one by one: the filter of a lock, the comparison with
// the planned edges, the records that take their errors, and the grid of locked lines. All of their
// state goes into one number a kind, which the PC and a board must both have. A number that changes
// tells that an edge is judged in another way; tools/checks/trace_numbers.py writes new numbers
// where that is meant.
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "account/records.h"
#include "clock/clock_filter.h"
#include "clock/clock_watch.h"
#include "clock/lock_grid.h"
#include "fakes/chance.h"
#include "fakes/trace.h"
#include "unity.h"

#define CLOCKS 12u
#define MANY   600u // and so many more on the PC, which has the time
#define EDGES  90u  // of a clock

static uint32_t taken; // edges

void setUp(void)
{
    trace_begin();
    taken = 0;
}

void tearDown(void)
{
    records_thin(1, UINT16_MAX);
    *lock_grid_now() = (struct lock_grid){.locks = false};
}

static bool one_in(uint8_t number)
{
    return chance_between(1, number) == 1u;
}

// This, or one more or less.
static uint32_t beside(uint32_t ticks)
{
    return ticks + chance_between(0, 2) - 1u;
}

// The argument is found before the sign.
static uint32_t either_way(uint32_t ticks)
{
    return one_in(2) ? 0u - ticks : ticks;
}

// Periods of all sizes, whole powers of two among them.
static uint32_t some_period(void)
{
    uint32_t ticks = (uint32_t)1024 << chance_between(0, 13);

    return one_in(3) ? ticks : ticks + chance_between(0, ticks - 1u);
}

// How far an edge lies from where it is expected: mostly near, often at a limit.
static uint32_t some_error(uint32_t period_ticks)
{
    static const uint16_t sizes[] = {4095, 4096, 0x3FF, 0x3FF0, 0x3FF1, INT16_MAX};

    switch (chance_between(0, 11)) {
    case 0:
        return either_way(beside(period_ticks / 4u));
    case 1:
        return either_way(beside(period_ticks / 8u));
    case 2:
        return either_way(beside(period_ticks / 16u));
    case 3:
        return either_way(beside(period_ticks / 2u));
    case 4:
        return either_way(beside(sizes[chance_between(0, 5)]));
    case 5:
        return either_way(beside(period_ticks / 32u));
    default:
        return chance_between(0, 6) - 3u;
    }
}

static void see_filter(const struct clock_filter *filter)
{
    trace_long(filter->expected.ticks);
    trace(filter->expected.fraction);
    trace_long(filter->period.ticks);
    trace(filter->period.fraction);
    trace(filter->edge);
    trace(filter->count);
    trace_long((uint32_t)filter->error_ticks);
    trace(filter->jitter);
    trace(filter->glitches);
    trace(filter->missing);
    trace((uint16_t)(filter->bridged << 8 | filter->shift));
    trace((uint16_t)(filter->stages << 8 | filter->fresh));
    trace((uint16_t)(filter->doubt << 8 | filter->shift_final));
}

// An edge where it is expected, or at a limit beside that.
static void one_edge(struct clock_filter *filter, uint32_t *edge_ticks)
{
    uint32_t expected = filter->count == 0 || filter->fresh == CLOCK_FILTER_RESTS
                            ? *edge_ticks + filter->nominal_ticks
                            : filter->expected.ticks;

    // A clock that only ever comes at limits settles never.
    if (one_in(3)) {
        expected += some_error(filter->period.ticks);
    }
    if (one_in(25)) {
        expected += filter->period.ticks * chance_between(1, 3);
    }
    if (clock_filter_edge(filter, expected)) {
        taken++;
    }
    *edge_ticks = expected;
}

static void filtered_clock(void)
{
    struct clock_filter filter = {.hold_over = (uint8_t)chance_between(0, 4)};
    uint32_t period_ticks = some_period();
    uint32_t edge_ticks = chance();

    clock_filter_aim(&filter, period_ticks, (uint16_t)chance_between(1, 60));
    for (uint16_t i = 0; i < EDGES; i++) {
        one_edge(&filter, &edge_ticks);
        see_filter(&filter);
        if (one_in(20)) {
            trace(clock_filter_bridge(&filter));
        }
        if (one_in(60)) {
            clock_filter_rest(&filter);
        }
        if (one_in(150)) {
            clock_filter_restart(&filter);
        }
        if (clock_filter_settled(&filter)) {
            trace_long(clock_filter_ahead(&filter, (uint16_t)chance_between(1, 900)));
        }
    }
}

// Half a tick ahead is a tick, less is none.
static void predictions_are_rounded(void)
{
    struct clock_filter filter = {.expected = {.ticks = 100, .fraction = 0x7FFF},
                                  .period = {.ticks = 1000, .fraction = 1}};

    TEST_ASSERT_EQUAL_UINT32(100, clock_filter_ahead(&filter, 1));
    TEST_ASSERT_EQUAL_UINT32(1101, clock_filter_ahead(&filter, 2));
    filter.expected.fraction = 0x8000;
    TEST_ASSERT_EQUAL_UINT32(101, clock_filter_ahead(&filter, 1));
}

static void see_watch(const struct clock_watch *watch)
{
    trace((uint16_t)(watch->following << 1 | watch->known));
    trace_long(watch->edges);
    trace_long(watch->edge_ticks);
    trace(watch->odd);
    trace_long(watch->next_ticks);
    trace(watch->near);
    trace(watch->near_ticks);
    trace(watch->pixel);
    trace(watch->phase);
    trace((uint16_t)watch->error_ticks);
    trace(watch->error_max_ticks);
}

static uint32_t watched_edge(const struct clock_watch *watch,
                             const struct pixel_period *period)
{
    uint32_t edge = watch->next_ticks;

    if (one_in(3)) {
        edge += some_error(period->whole_ticks);
    } else if (one_in(3)) {
        // As far off as the edge before, or at the limit of that.
        edge +=
            (uint32_t)(int32_t)watch->error_ticks + either_way(beside(watch->near_ticks));
    }
    if (one_in(20)) {
        edge += period->whole_ticks * chance_between(1, 6);
    }
    return edge;
}

static void watched_clock(void)
{
    struct clock_watch watch = {.divider = (uint16_t)chance_between(0, 3)};
    struct pixel_period period;
    uint16_t pixel = 0;

    uint32_t thirds = 3u * some_period();

    thirds += one_in(2) ? 0u : 1u;
    TEST_ASSERT_TRUE(pixel_period_set(&period, 16000000uL, 48000000uL, thirds));
    clock_watch_follow(&watch, &period, chance());
    for (uint16_t i = 0; i < EDGES; i++) {
        taken++;
        trace(clock_watch_edge(&watch, &period, watched_edge(&watch, &period), &pixel));
        trace(pixel);
        see_watch(&watch);
        if (one_in(40)) {
            clock_watch_rest(&watch);
        }
        if (one_in(40)) {
            clock_watch_forget(&watch);
        }
        if (!watch.following && one_in(3)) {
            clock_watch_follow(&watch, &period, watch.edge_ticks + period.whole_ticks);
        }
    }
}

// 2^24 ticks are too many for 16 bits of 256 ticks each.
static void odd_intervals_as_they_are_shown(void)
{
    static const struct {
        uint32_t ticks;
        uint16_t shown;
    } rows[] = {{0xFFFFFF, UINT16_MAX},
                {0x1000000, UINT16_MAX},
                {0x1234567, UINT16_MAX},
                {0xFFFDFF, 0xFFFD},
                {0x8000FF, 0x8001},
                {256, 1}};

    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        struct clock_watch watch = {.known = true, .edge_ticks = 77};

        clock_watch_interval(&watch, 100000, 77u + rows[i].ticks);
        TEST_ASSERT_EQUAL_UINT16(rows[i].shown, watch.odd);
    }
}

// The error of a locked clock's edge, within 16 bits.
static void errors_are_saturated(void)
{
    static const struct {
        int32_t error;
        int16_t shown;
    } rows[] = {{32766, 32766},
                {32767, 32767},
                {32768, 32767},
                {-32766, -32766},
                {-32767, -32767},
                {-32768, -32767},
                {70000, 32767},
                {-70000, -32767}};

    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        struct clock_watch watch = {.known = true};

        clock_watch_note(&watch, rows[i].error);
        TEST_ASSERT_EQUAL_INT16(rows[i].shown, watch.error_ticks);
    }
}

// Nearly half a period of 0x8000 ticks on: near_ticks stays so that sixteen of them fit 15 bits.
static void what_counts_as_near(void)
{
    static const struct {
        uint32_t period;
        uint16_t near_ticks;
    } rows[] = {{1024, 31},
                {2048, 63},
                {0x7FE0, 0x3FE},
                {0x8000, 0x3FF},
                {0x8020, 0x3FF},
                {0x1000000, 0x3FF}};

    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        struct pixel_period period = {.whole_ticks = rows[i].period, .divisor = 1};
        struct clock_watch watch = {.near = true, .error_ticks = 5, .phase = 3};

        clock_watch_follow(&watch, &period, 0);
        TEST_ASSERT_EQUAL_UINT16(rows[i].near_ticks, watch.near_ticks);
        TEST_ASSERT_FALSE(watch.near);
        TEST_ASSERT_EQUAL_INT16(0, watch.error_ticks);
        TEST_ASSERT_EQUAL_UINT16(0, watch.phase);
    }
}

static void see_records(const struct records *records)
{
    trace((uint16_t)(records->newest << 8 | records->count));
    trace(records->passing);
    trace(records->made);
    trace(records->to_next);
    trace((uint16_t)records->shown_ticks);
    for (uint8_t i = 0; i < RECORDS_EARLY; i++) {
        trace((uint16_t)records->early_ticks[i]);
    }
    for (uint8_t i = 0; i < records->count; i++) {
        struct pixel_record record = records_get(records, i);
        trace(record.pixel);
        trace((uint16_t)record.edge_error_ticks);
        trace((uint16_t)record.expected_steps);
        trace(records_word(records, i, (uint8_t)chance_between(0, 5)));
    }
}

static int16_t some_edge_error(void)
{
    uint32_t error = one_in(4) ? chance_between(0, 40) : 20u * chance_between(0, 2);

    return (int16_t)error;
}

// The next pixel passes, or the clock's edge of one around it comes, many before or behind it.
static void pixel_or_edge(struct records *records, uint16_t *pixel)
{
    if (one_in(2)) {
        (*pixel)++;
        int32_t steps = 10 * (int32_t)*pixel;
        records_add(records, *pixel, steps + (one_in(6) ? 1 : 0), (uint16_t)steps);
    } else {
        uint16_t of = (uint16_t)(*pixel - (one_in(3) ? 25u : 3u));
        of = (uint16_t)(of + chance_between(0, one_in(3) ? 40 : 10));
        records_note_error(records, of, some_edge_error());
    }
}

// Pixels pass, or clock edges of pixels around the newest one come: many before or behind it.
static void recorded_line(void)
{
    struct records records;
    uint16_t pixel = (uint16_t)(one_in(2) ? 0u : 0xFFF0u);

    uint16_t every = (uint16_t)chance_between(1, 4);

    records_thin(every, (uint16_t)(20u * chance_between(0, 2)));
    for (uint8_t i = 0; i < RECORDS_EARLY; i++) {
        records.early_ticks[i] = 99; // of the line before
    }
    records.newest = 3;
    records.passing = true;
    records_reset(&records);
    see_records(&records);
    for (uint16_t i = 0; i < EDGES; i++) {
        taken++;
        pixel_or_edge(&records, &pixel);
        if (one_in(3)) {
            see_records(&records);
        }
    }
}

static void see_grid(const struct line_grid *grid)
{
    const struct lock_grid *lock = lock_grid_now();
    uint16_t number = 0;

    trace(line_grid_early(grid, false));
    trace(line_grid_early(grid, true));
    trace(grid->edge);
    trace_long(grid->reached.ticks);
    trace(lock->newest);
    trace(lock->newest_edge);
    trace(lock_grid_passes(&number));
    trace(number);
    trace(lock->due_edge);
    trace(lock_grid_tolerates());
}

static uint32_t lock_edge_ticks; // newest edge of the lock's clock
static uint32_t lock_period_ticks;

// A clock that is known.
static void begin_lock(void)
{
    struct lock_grid *lock = lock_grid_now();

    lock_period_ticks = some_period() / 2u + 1024u;
    lock_edge_ticks = chance();
    *lock = (struct lock_grid){.locks = true, .divider = (uint16_t)chance_between(1, 6)};
    lock->lead_edges = (uint16_t)chance_between(1, 8);
    lock->pixel = (struct pixel_period){.whole_ticks = lock_period_ticks * lock->divider,
                                        .divisor = 1};
#if SEVERAL_AXES
    lock->more_edges = (uint16_t)chance_between(0, 2);
#endif
    lock_grid_tolerate(lock_period_ticks / (uint32_t)chance_between(40, 400));
    trace_long(lock->slack_ticks);
    lock->filter.hold_over = 4;
    clock_filter_aim(&lock->filter, lock_period_ticks, lock->lead_edges);
    lock_edge_ticks += either_way(chance_between(0, lock->tolerance_ticks));
    for (uint8_t i = 0; i < 40u; i++) {
        lock_edge_ticks += lock_period_ticks;
        (void)clock_filter_edge(&lock->filter, lock_edge_ticks);
    }
    lock_grid_hold_period();
}

// A line gets its place, after some pixels that are decoded without one.
static void place_line(struct line_grid *grid)
{
    line_grid_start_locked(grid);
    for (uint8_t left = (uint8_t)chance_between(0, 5); left != 0; left--) {
        trace_long(line_grid_advance(grid));
        see_grid(grid);
    }
    uint16_t ahead = (uint16_t)chance_between(0, 5);
    uint32_t zero = lock_grid_begin(ahead);

    trace_long(zero);
#if SEVERAL_AXES
    lock_grid_keep(line_grid_decoded(grid, 0), zero);
#endif
    line_grid_place(grid, 0, zero);
}

// A line along a lock's edges: before it has its place, and behind that.
static void locked_line(void)
{
    struct lock_grid *lock = lock_grid_now();
    struct line_grid grid;

    begin_lock();
    place_line(&grid);
    for (uint8_t i = 0; i < EDGES / 3u; i++) {
        taken++;
        lock_edge_ticks += lock_period_ticks;
        lock_edge_ticks += either_way(chance_between(0, lock->tolerance_ticks / 2u));
        (void)clock_filter_edge(&lock->filter, lock_edge_ticks);
        see_grid(&grid);
        while (!line_grid_early(&grid, one_in(2))) {
            trace_long(line_grid_advance(&grid));
        }
    }
}

static void check(uint32_t wanted)
{
    TEST_ASSERT_EQUAL_HEX32(wanted, trace_number());
}

static void clocks(void (*clock)(void), uint32_t seed, uint32_t wanted, uint32_t many)
{
    chance_seed(seed);
    for (uint8_t left = CLOCKS; left != 0; left--) {
        clock();
    }
    TEST_ASSERT_TRUE(taken > 20u * CLOCKS);
    check(wanted);
#if defined(__AVR__)
    (void)many;
#else
    for (uint16_t left = MANY; left != 0; left--) {
        clock();
    }
    check(many);
#endif
}

static void clocks_that_are_filtered(void)
{
    clocks(filtered_clock, 0xE0A1uL, 0xBD790F6DuL, 0x7C230A1BuL);
}

static void clocks_that_are_compared_with_a_plan(void)
{
    clocks(watched_clock, 0xE0A2uL, 0xA679B63AuL, 0xD52F3C1AuL);
}

static void errors_that_find_their_records(void)
{
    clocks(recorded_line, 0xE0A3uL, 0x70927D72uL, 0x1F613B3CuL);
}

static void lines_along_a_lock(void)
{
    clocks(locked_line, 0xE0A4uL, 0xD0A86FA2uL, 0x377B1E1AuL);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(clocks_that_are_filtered);
    RUN_TEST(predictions_are_rounded);
    RUN_TEST(clocks_that_are_compared_with_a_plan);
    RUN_TEST(odd_intervals_as_they_are_shown);
    RUN_TEST(errors_are_saturated);
    RUN_TEST(what_counts_as_near);
    RUN_TEST(errors_that_find_their_records);
    RUN_TEST(lines_along_a_lock);
    return UNITY_END();
}
