// SPDX-License-Identifier: MIT
// One axis through random lines of every kind, and all that its decoder, its stream and its account
// do on the way, as one number a kind. The C of this suite on the PC and the assembly on a board
// must do the same at every call: decode the same entries for the same budget, wait for the same
// room, note the same marks and batches, account for the same periods. A number that changes tells
// that something is decoded or accounted for in another order or amount. If that is meant, the new
// number is what the native suite prints; every board must have it, too.
#include <stdbool.h>
#include <stdint.h>

#include "axis/decode.h"
#include "clock/lock_grid.h"
#include "fakes/axis_bench.h"
#include "fakes/chance.h"
#include "fakes/promise.h"
#include "fakes/trace.h"
#include "line/segment_pack.h"
#include "steps/train_pixel.h"
#include "unity.h"

#define LEAD_EDGES  3u
#define LINES       16u    // of a kind
#define MANY        600u   // and so many more on the PC, which has the time
#define LEAST_TICKS 64u    // interval of a line, by the bench's limits
#define DONE_AFTER  30000u // rounds of a line

static bool locked;
static uint32_t clock_ticks; // newest edge of a lock's clock
static uint32_t clock_period_ticks;
static uint16_t ended; // lines that came to their end
static uint32_t edges;

void setUp(void)
{
    promise_broken = 0;
    trace_begin();
    ended = 0;
    edges = 0;
    locked = false;
    *lock_grid_now() = (struct lock_grid){.locks = false};
}

void tearDown(void)
{
    TEST_ASSERT_EQUAL_UINT16(0, promise_broken);
    *lock_grid_now() = (struct lock_grid){.locks = false};
}

static void see_marks(const struct stream *stream)
{
    for (uint8_t m = stream->waypoint_tail; m != stream->waypoint_head; m++) {
        const struct waypoint *mark = &stream->waypoints[m & (STREAM_WAYPOINTS - 1u)];
        // A mark that waits has no slot yet.
        bool waits = (uint8_t)(m - stream->waypoint_placed) < STREAM_WAYPOINTS;
        trace(waits ? 0 : mark->slot);
        trace(mark->way);
        trace(mark->way < WAYPOINT_START ? mark->position : 0);
        trace_long(waits ? 0 : waypoint_ticks(mark));
    }
}

static void see_stream(const struct stream *stream)
{
    trace((uint16_t)(stream->head << 8 | stream->retired));
    trace_long(stream->end_ticks);
    trace(stream->trains[0].steps);
    trace(stream->trains[1].steps);
    trace(stream->plain);
    see_marks(stream);
}

static void see_line(const struct axis *axis)
{
    trace((uint16_t)axis->line.position);
    trace(axis->line.room);
    trace((uint16_t)(axis->phase << 8 | axis->life.state));
    trace(decode_is_ahead(axis));
    trace_long(decode_ahead_ticks(axis));
    trace((uint16_t)axis->line.curve_half);
    trace(axis->line.source.edge_open);
    // From here the next curved pixel may go on.
    if (axis->line.curve_half != 0 && axis->walk.steps.curve.state.steep.good) {
        trace_long(axis->walk.steps.curve.state.steep.last_ticks);
        trace_long((uint32_t)axis->walk.steps.curve.state.steep.change);
    }
    if (axis->phase == DECODE_STEPS) {
        trace(axis->walk.until);
        trace_long(axis->walk.exact_ticks);
    }
}

static void see_records(const struct records *records)
{
    trace(records->made);
    if (records->count != 0) {
        struct pixel_record record = records_get(records, (uint8_t)(records->count - 1u));
        trace(record.pixel);
        trace((uint16_t)record.expected_steps);
        trace_long((uint32_t)record.actual_steps);
    }
}

static void see_ledger(const struct ledger *ledger)
{
    trace_long((uint32_t)ledger->position_steps);
    trace_long(ledger->loaded_ticks);
    trace((uint16_t)ledger->pixel);
    trace(ledger->left);
    trace((uint16_t)(ledger->train << 8 | ledger->fresh));
    trace((uint16_t)ledger_train_loaded(ledger));
    see_records(&ledger->records);
}

// The periods that the account still knows.
static void see_periods(void)
{
    struct axis *axis = &bench.axis;

    for (uint8_t back = 0; back < 3u; back++) {
        trace_long(ledger_period_start(&axis->ledger, &axis->feed.stream, back));
    }
    trace(ledger_steps_after(
        &axis->ledger, &axis->feed.stream, bench.now_ticks - STEP_IDLE_TICKS / 2u, 100));
    trace(ledger_idles(&axis->ledger));
}

static void see_capture(const struct engine_sample *sample)
{
    struct axis *axis = &bench.axis;

    uint8_t back = (uint8_t)chance_between(0, 2);
    uint16_t ticks = (uint16_t)chance_between(0, 200);

    trace_long(ledger_advance_to_capture(
        &axis->ledger, &axis->feed.stream, sample, back, ticks));
}

// The account lags, comes up, or places an edge.
static void follow(void)
{
    struct axis *axis = &bench.axis;
    struct ledger *ledger = &axis->ledger;
    struct stream *stream = &axis->feed.stream;
    struct engine_sample sample = step_engine_sample(&bench.engine);

    trace(ledger_due(ledger, stream, &sample));
    // Full marks keep the decoder from the next pixel.
    switch (stream_waypoints_full(stream) ? 2u : chance_between(0, 11)) {
    case 0:
        ledger_advance(ledger, stream, &sample, LEDGER_EXACTLY);
        see_periods();
        break;
    case 1:
        see_capture(&sample);
        break;
    case 2:
    case 3:
        ledger_advance(ledger, stream, &sample, LEDGER_BY_WAYPOINTS);
        trace((uint16_t)ledger_position_at(ledger, stream, sample.tail));
        break;
    case 4:
        trace(ledger_advance_plain(ledger, stream, sample.tail));
        break;
    case 5:
    case 6:
        if (ledger_due(ledger, stream, &sample)) {
            ledger_advance(ledger, stream, &sample, LEDGER_BY_WAYPOINTS);
        }
        break;
    default:
        return;
    }
    see_ledger(ledger);
}

// The clock's edges up to now.
static void clock_edges(void)
{
    while (locked && (int32_t)(bench.now_ticks - clock_ticks - clock_period_ticks) >= 0) {
        clock_ticks += clock_period_ticks;
        (void)clock_filter_edge(&lock_grid_now()->filter,
                                clock_ticks + chance_between(0, 40));
    }
}

static void load_periods(void)
{
    for (uint8_t left = (uint8_t)chance_between(0, 7); left != 0; left--) {
        struct step_load load = step_engine_next(&bench.engine, &bench.ring);
        trace(load.top_ticks);
        trace(load.pulse);
        bench.now_ticks += (uint32_t)load.top_ticks + 1u;
        if (load.pulse) {
            edges++;
            bench.steps += bench.engine.negative ? -1 : 1;
        }
    }
}

static void decode(void)
{
    static const uint8_t budgets[] = {1, 5, 12, 30, 64, 120, 120, 255};
    struct axis *axis = &bench.axis;

#if SEVERAL_AXES
    axis->made_entries = (uint8_t)(bench.engine.tail - axis->feed.stream.retired);
#endif
    trace(decode_axis(
        axis, &bench.period, budgets[chance_between(0, sizeof budgets - 1u)]));
    see_stream(&axis->feed.stream);
    see_line(axis);
}

// A round of the main loop: the interrupt makes periods, the account follows or does not, and the
// decoder goes on if it is not ahead.
static void round_of_axis(void)
{
    load_periods();
    clock_edges();
    follow();
    if (chance_between(0, 3) != 0) {
        decode();
    }
}

static bool begins(void)
{
    struct axis *axis = &bench.axis;

    for (uint8_t turns = 0; !decode_is_ahead(axis) && turns < 200u; turns++) {
        decode();
    }
    trace((uint16_t)axis->feed.lead_in_ticks);
    bench.zero_ticks = bench.now_ticks + BENCH_DELAY_TICKS;
    if (axis->feed.merge) {
        return false; // its first step is not known yet
    }
    feed_release(&axis->feed, axis->feed.lead_in_ticks + BENCH_DELAY_TICKS);
    axis_place(axis, bench.zero_ticks);
    if (locked && line_grid_locked(&axis->line.edges)) {
        line_grid_place(&axis->line.edges, 0, lock_grid_begin(1));
    }
    return axis_released(axis);
}

static void bring_to_rest(void)
{
    struct axis *axis = &bench.axis;

    axis_stop(axis);
    step_engine_halt(&bench.engine);
    for (uint8_t i = 0; i < 4u; i++) {
        struct step_load load = step_engine_next(&bench.engine, &bench.ring);
        bench.now_ticks += (uint32_t)load.top_ticks + 1u;
    }
    struct engine_sample sample = step_engine_sample(&bench.engine);
    ledger_advance(&axis->ledger, &axis->feed.stream, &sample, LEDGER_EXACTLY);
    see_ledger(&axis->ledger);
    see_periods();
    trace(ledger_settle_play(&axis->ledger));
    uint8_t slot = 0;
    TEST_ASSERT_TRUE(step_engine_settle(&bench.engine, &bench.ring, &slot));
    axis_discard(axis, slot);
    see_line(axis);
}

// Run what is queued to its end, or stop it somewhere.
static void run(void)
{
    struct axis *axis = &bench.axis;
    uint16_t most =
        chance_between(0, 5) == 0 ? (uint16_t)chance_between(1, 400) : DONE_AFTER;

    if (!axis_arm(axis, &bench.period) || !begins()) {
        bring_to_rest();
        return;
    }
    for (uint16_t rounds = 0; rounds < most && !bench_finish_line(); rounds++) {
        round_of_axis();
        if (bench.engine.state == STEP_ENGINE_HALTED) {
            break; // it starved, as a line in the middle of a batch may
        }
        if (segment_source_ends_early(&axis->line.source) && chance_between(0, 40) == 0) {
            segment_source_trip(&axis->line.source);
        }
    }
    if (axis->life.state == AXIS_RUNNING) {
        bring_to_rest();
    } else {
        ended++;
    }
    trace((uint16_t)bench.steps);
    trace(axis->ledger.lines_done);
    trace(axis->play_unknown);
}

static void queue(int16_t count, uint16_t repeat)
{
    trace((uint16_t)bench_queue(count, repeat));
}

// One pixel more, in the shortest form that it has now and then.
static void queue_pixel(int16_t count, int16_t last)
{
    int16_t change = (int16_t)(count - last);
    uint8_t byte = (uint8_t)((int16_t)SEGMENT_NEAR_ZERO + change);

    if (change >= -56 && change <= 56 && chance_between(0, 2) != 0) {
        trace((uint16_t)bench_queue_block(bench.axis.next_block, &byte, 1, true));
        return;
    }
    queue(count, (uint16_t)chance_between(1, 2));
}

static int16_t start_word(uint16_t flags)
{
    return (int16_t)(uint16_t)(LINE_MARK_START | LINE_START_WAIT | flags);
}

// Plain pixels of few or many steps, either way, with rests.
static void queue_plain(uint16_t most_steps, uint8_t pixels, bool turns)
{
    int16_t last = 0;

    queue(start_word(0), 0);
    queue(0, 0);
    for (; pixels != 0; pixels--) {
        int16_t count =
            (int16_t)chance_between(chance_between(0, 9) == 0 ? 0 : 1, most_steps);
        if (chance_between(0, 3) == 0 && last > 0) {
            count = last;
        }
        if (turns && chance_between(0, 4) == 0) {
            count = (int16_t)-count;
        }
        queue_pixel(count, last);
        last = count;
    }
    queue((int16_t)LINE_MARK_END, 0);
}

// Even speeds of a smooth line, each near the one before or far from it, and back to rest.
static void queue_speeds(uint16_t top_speed, uint8_t pixels)
{
    uint16_t speed = 0;

    for (; pixels != 0; pixels--) {
        uint16_t next = (uint16_t)(2u * chance_between(1, top_speed / 2u));
        if (chance_between(0, 2) == 0 && speed != 0) {
            next = speed;
        }
        // A pixel at half the sum of its two speeds.
        queue((int16_t)((speed + next) / 2u), 1);
        speed = next;
    }
    queue((int16_t)(speed / 2u), 1);
    queue((int16_t)LINE_MARK_END, 0);
}

static void queue_smooth(uint16_t top_speed, uint8_t pixels)
{
    uint16_t direction = chance_between(0, 1) == 0 ? 0 : LINE_START_NEGATIVE;

    queue(start_word((uint16_t)(LINE_START_SMOOTH | direction)), 0);
    queue(0, 0);
    queue_speeds(top_speed, pixels);
}

// A ramp to the line's speed, some pixels at it, and the ramp back; with play to be taken up.
static void queue_backlash(uint16_t line_speed, uint8_t ramp)
{
    uint16_t direction = chance_between(0, 1) == 0 ? 0 : LINE_START_NEGATIVE;
    uint16_t steps = (uint16_t)chance_between(1, line_speed);
    uint16_t each = (uint16_t)(line_speed / (2u * ramp));

    queue(start_word((uint16_t)(LINE_START_SMOOTH | direction)), 0);
    queue((int16_t)steps, (uint16_t)(2u * ramp * each));
    queue(0, 1);
    for (uint8_t i = 0; i < ramp; i++) {
        queue((int16_t)((2u * i + 1u) * each), 1);
        // Even pixels that run ahead of the clock.
        if (i + 1u < ramp && chance_between(0, 1) == 0) {
            queue((int16_t)((2u * i + 2u) * each), (uint16_t)chance_between(1, 3));
        }
    }
    queue((int16_t)(2u * ramp * each), (uint16_t)chance_between(1, 4));
    for (uint8_t i = ramp; i-- != 0;) {
        queue((int16_t)((2u * i + 1u) * each), 1);
    }
    queue(0, 1);
    queue((int16_t)LINE_MARK_END, 0);
}

static void queue_seek(uint16_t speed, uint8_t ramp)
{
    uint16_t each = (uint16_t)(speed / (2u * ramp));

    queue((int16_t)(uint16_t)(LINE_MARK_START | LINE_START_SEEK | LINE_START_SMOOTH), 0);
    queue(0, 0);
    for (uint8_t i = 0; i < ramp; i++) {
        queue((int16_t)((2u * i + 1u) * each), 1);
    }
    queue((int16_t)(2u * ramp * each), (uint16_t)chance_between(4, 40));
    queue((int16_t)LINE_MARK_DOWN, 0);
    for (uint8_t i = ramp; i-- != 0;) {
        queue((int16_t)((2u * i + 1u) * each), 1);
    }
    queue((int16_t)LINE_MARK_END, 0);
}

static void open_axis(uint32_t hz_num, uint32_t hz_den)
{
    bench_open(hz_num, hz_den);
    bench.limits.min_interval_ticks = LEAST_TICKS;
    bench.limits.smooth_min_interval_ticks = 2u * LEAST_TICKS;
    bench.limits.seek_min_interval_ticks = 4u * LEAST_TICKS;
    bench_stagger((uint8_t)(2u * chance_between(0, TRAIN_STAGGER_MAX / 2u)));
    records_thin((uint16_t)chance_between(1, 3), UINT16_MAX);
}

// The most steps of a pixel, by its shortest interval, and no more than so many.
static uint16_t most_steps(uint16_t interval_ticks, uint16_t most)
{
    uint32_t steps = bench.period.whole_ticks / interval_ticks;

    return steps < most ? (uint16_t)steps : most;
}

// Frequencies of the clock: long pixels and short ones, some of them with a fraction of a tick; and
// pixels around the lengths from which on they are decoded in another way.
static void open_any(void)
{
    static const uint16_t hz[] = {30, 61, 97, 244, 245, 400, 997, 1000, 2000, 3100, 5000};
    static const uint32_t sizes[] = {0x2000, 0xFC00, 0x10000, 0x20000, 0x40000};
    uint32_t den = chance_between(0, 1) == 0 ? 1u : 7u;

    if (chance_between(0, 2) == 0) {
        uint32_t ticks = sizes[chance_between(0, sizeof sizes / sizeof sizes[0] - 1u)];
        open_axis(16000000, ticks + chance_between(0, 2) - 1u);
        return;
    }
    open_axis(den * hz[chance_between(0, sizeof hz / sizeof hz[0] - 1u)] + (den != 1u),
              den);
}

// Pixels of a whole number of these ticks for each step, or a tick beside that.
static void open_limit(uint32_t interval_ticks, uint16_t steps)
{
    uint32_t ticks = interval_ticks * steps + chance_between(0, 2) - 1u;

    open_axis(16000000, ticks < PIXEL_PERIOD_MIN_TICKS ? PIXEL_PERIOD_MIN_TICKS : ticks);
}

static void check(uint32_t wanted)
{
    TEST_ASSERT_EQUAL_HEX32(wanted, trace_number());
}

// So many lines of a kind, on a board of several axes and on that of one; many: of many more,
// natively. Most lines come to their end.
static void lines(
    void (*line)(void), uint32_t seed, uint32_t several, uint32_t one, uint32_t many)
{
    chance_seed(seed);
    for (uint8_t left = LINES; left != 0; left--) {
        line();
    }
    TEST_ASSERT_TRUE(ended >= LINES / 4u);
    TEST_ASSERT_TRUE(edges > 30u * LINES);
    check(SEVERAL_AXES ? several : one);
#if defined(__AVR__) || !SEVERAL_AXES
    (void)many;
#else
    for (uint16_t left = MANY; left != 0; left--) {
        line();
    }
    check(many);
#endif
}

static void plain_few(void)
{
    open_any();
    queue_plain(most_steps(140, 24), 20, false);
    run();
}

static void plain_pixels_of_few_steps(void)
{
    lines(plain_few, 0x51A1uL, 0x222DE1DAuL, 0x96A762D3uL, 0xBD429799uL);
}

static void plain_many(void)
{
    open_any();
    queue_plain(most_steps(70, 700), 8, false);
    run();
}

static void plain_pixels_of_many_steps(void)
{
    lines(plain_many, 0x51A2uL, 0xECB435A3uL, 0xB87D6B01uL, 0x3A9EDE1DuL);
}

// Intervals and counts around those at which a pixel goes another way.
static void at_limit(void)
{
    static const uint32_t intervals[] = {64,     100,    127,    128,    129,    159,
                                         160,    161,    255,    256,    257,    8192,
                                         16384,  32767,  32768,  0x6FFF, 0x7000, 0xFBFE,
                                         0xFBFF, 0xFC00, 0xFCFF, 0xFD00, 0xFD01, 0x10000};
    static const uint8_t counts[] = {1,  2,   4,   8,   15,  16,  17,  32,  59,  60, 61,
                                     64, 119, 120, 121, 126, 127, 128, 129, 254, 255};
    uint32_t interval =
        intervals[chance_between(0, sizeof intervals / sizeof intervals[0] - 1u)];
    int16_t count =
        (int16_t)counts[chance_between(0, interval > 1000u ? 13u : sizeof counts - 1u)];

    open_limit(interval, (uint16_t)count);
    queue(start_word(0), 0);
    queue(0, 0);
    if (chance_between(0, 1) == 0) {
        queue(count, (uint16_t)chance_between(1, 3));
        queue((int16_t)(count + 1 - (int16_t)chance_between(0, 2)), 1);
    }
    queue(count, (uint16_t)chance_between(4, 9));
    queue((int16_t)LINE_MARK_END, 0);
    run();
}

static void pixels_at_every_limit(void)
{
    lines(at_limit, 0x51ABuL, 0x87106EE6uL, 0x9AE6E278uL, 0x2D0F10FBuL);
}

// Many pixels without a step: more marks than there are, and times of many periods.
static void with_rests(void)
{
    open_any();
    queue(start_word(0), 0);
    queue(0, 0);
    for (uint8_t left = 4; left != 0; left--) {
        int16_t count = (int16_t)chance_between(1, 12);
        queue(count, (uint16_t)chance_between(1, 4));
        queue(0, (uint16_t)chance_between(1, 40));
    }
    queue(5, 1);
    queue((int16_t)LINE_MARK_END, 0);
    run();
}

static void pixels_between_rests(void)
{
    lines(with_rests, 0x51AEuL, 0x3685AA11uL, 0xBDC7408DuL, 0x0D876BEDuL);
}

// A segment of more pixels than a byte counts, whose last ones are the last of 256 or of 512.
static void long_runs(void)
{
    open_axis(16000000, 4096u * chance_between(1, 2));
    queue(start_word(0), 0);
    queue(0, 0);
    int16_t count = (int16_t)chance_between(5, 9);
    uint32_t pixels = 256u * chance_between(1, 2);
    pixels += chance_between(0, 2) - 1u;
    queue(count, (uint16_t)pixels);
    queue(count, 1);
    queue((int16_t)LINE_MARK_END, 0);
    run();
}

static void runs_of_many_pixels(void)
{
    lines(long_runs, 0x51AFuL, 0x9E1724C0uL, 0xBE1DC7AEuL, 0x29C6347CuL);
}

static void plain_turns(void)
{
    open_any();
    bench.limits.reversal_min_ticks = (uint16_t)chance_between(100, 2000);
    bench.axis.feed.reversal_ticks = bench.limits.reversal_min_ticks;
    queue_plain(most_steps(400, 130), 14, true);
    run();
}

static void plain_pixels_that_turn(void)
{
    lines(plain_turns, 0x51A3uL, 0x8B2B8FCEuL, 0xD81A8F9CuL, 0x8F6340D9uL);
}

static void smooth_few(void)
{
    open_any();
    queue_smooth(most_steps(300, 60), 12);
    run();
}

static void smooth_pixels_of_few_steps(void)
{
    lines(smooth_few, 0x51A4uL, 0xD435B65DuL, 0x77C2AD2AuL, 0xD2F05AFDuL);
}

static void smooth_many(void)
{
    open_any();
    queue_smooth(most_steps(150, 900), 6);
    run();
}

static void smooth_pixels_of_many_steps(void)
{
    lines(smooth_many, 0x51A5uL, 0x595694FDuL, 0x325C1455uL, 0xAB0E7EC0uL);
}

// Speeds that come back, so that one pixel's acceleration is that of the one before it, or of one
// some pixels ago.
static void like_before(void)
{
    static const uint8_t speeds[] = {
        8, 16, 24, 32, 32, 16, 150, 150, 16, 32, 48, 64, 200, 190, 180};
    uint16_t speed = 0;
    uint16_t most = 0;

    open_any();
    most = most_steps(150, 200);
    queue(start_word(LINE_START_SMOOTH), 0);
    queue(0, 0);
    for (uint8_t i = (uint8_t)chance_between(0, 5); i < (uint8_t)sizeof speeds; i++) {
        uint16_t next = speeds[i] <= most ? speeds[i] : (uint16_t)(most & 0xFFFEu);
        queue((int16_t)((speed + next) / 2u), 1);
        speed = next;
    }
    queue((int16_t)(speed / 2u), 1);
    queue((int16_t)LINE_MARK_END, 0);
    run();
}

static void accelerations_that_come_back(void)
{
    lines(like_before, 0x51ACuL, 0xF637D1BAuL, 0x55E17F1EuL, 0x7ECCB97AuL);
}

static void play_quickly(void)
{
    open_any();
    bench.limits.smooth_min_interval_ticks = LEAST_TICKS;
    queue_backlash(most_steps((uint16_t)chance_between(66, 190), 700), 4);
    run();
}

static void lines_with_play_at_short_intervals(void)
{
    lines(play_quickly, 0x51ADuL, 0xEF3F0FAFuL, 0x34ECF29AuL, 0xF6373E66uL);
}

static void with_play(void)
{
    open_any();
    uint16_t speed = most_steps(200, 500);
    queue_backlash(speed, 3);
    run();
    queue_backlash(speed, 2);
    run();
}

static void lines_with_play(void)
{
    lines(with_play, 0x51A6uL, 0x3E38172CuL, 0xB915889AuL, 0x3D54C3CEuL);
}

static void one_seek(void)
{
    open_any();
    queue_seek(most_steps(600, 300), 2);
    run();
}

static void seeks(void)
{
    lines(one_seek, 0x51A7uL, 0xB74E40B5uL, 0x30E619CDuL, 0xD08FDC38uL);
}

// Lines that follow each other without a pause, of both kinds.
static void chained(void)
{
    open_any();
    queue_plain(most_steps(200, 60), 5, false);
    TEST_ASSERT_TRUE(bench_queue_run(
        (int16_t)LINE_MARK_START, (int16_t)chance_between(1, most_steps(200, 90)), 3));
    run();
    run();
}

static void chained_lines(void)
{
    lines(chained, 0x51A8uL, 0xC695FBCCuL, 0x2ED4B26CuL, 0x77856D59uL);
}

static void open_clock(uint16_t divider)
{
    struct lock_grid *grid = lock_grid_now();

    locked = true;
    *grid =
        (struct lock_grid){.locks = true, .divider = divider, .lead_edges = LEAD_EDGES};
    grid->pixel = bench.period;
    lock_grid_tolerate(bench.period.whole_ticks / divider / 100u);
    grid->filter.hold_over = 4;
    clock_period_ticks = bench.period.whole_ticks / divider;
    clock_filter_aim(&grid->filter, clock_period_ticks, (uint16_t)(LEAD_EDGES + divider));
    clock_period_ticks += chance_between(0, clock_period_ticks / 500u);
    clock_ticks = bench.now_ticks + BENCH_DELAY_TICKS - 61u * clock_period_ticks;
    for (uint8_t i = 0; i < 60u; i++) {
        clock_ticks += clock_period_ticks;
        (void)clock_filter_edge(&grid->filter, clock_ticks);
    }
    lock_grid_hold_period();
}

static void one_locked(void)
{
    open_any();
    open_clock((uint16_t)chance_between(1, 3));
    if (chance_between(0, 1) == 0) {
        queue_plain(most_steps(200, 200), 8, false);
    } else {
        queue_smooth(most_steps(250, 200), 8);
    }
    run();
}

static void locked_lines(void)
{
    lines(one_locked, 0x51A9uL, 0x8FC70665uL, 0xCE1A2387uL, 0xBC1507B2uL);
}

static void locked_with_play(void)
{
    open_any();
    open_clock((uint16_t)chance_between(1, 3));
    queue_backlash(most_steps(300, 300), 2);
    run();
}

static void locked_lines_with_play(void)
{
    lines(locked_with_play, 0x51AAuL, 0x43409577uL, 0xAE52217DuL, 0xB425B816uL);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(plain_pixels_of_few_steps);
    RUN_TEST(plain_pixels_of_many_steps);
    RUN_TEST(pixels_at_every_limit);
    RUN_TEST(pixels_between_rests);
    RUN_TEST(runs_of_many_pixels);
    RUN_TEST(plain_pixels_that_turn);
    RUN_TEST(smooth_pixels_of_few_steps);
    RUN_TEST(smooth_pixels_of_many_steps);
    RUN_TEST(accelerations_that_come_back);
    RUN_TEST(lines_with_play);
    RUN_TEST(lines_with_play_at_short_intervals);
    RUN_TEST(seeks);
    RUN_TEST(chained_lines);
    RUN_TEST(locked_lines);
    RUN_TEST(locked_lines_with_play);
    return UNITY_END();
}
