// SPDX-License-Identifier: MIT
// Pixels that are decoded as a whole, those of few steps and those that are one pulse train, from
// queue to STEP edge and record. Every edge is compared with the tick that the count of its pixel
// asks for, found here by wide integers and search, and most pixels must have gone the way that is
// meant for them.
#include <stdint.h>

#include "axis/decode.h"
#include "fakes/axis_bench.h"
#include "fakes/chance.h"
#include "fakes/promise.h"
#include "line/segment_pack.h"
#include "steps/even_pixel.h"
#include "steps/train_pixel.h" // TRAIN_PIXEL_MAX_STEPS
#include "unity.h"

#define PIXELS 40u

static int16_t counts[PIXELS + 1u];
static uint8_t pixels;
static uint16_t speeds[PIXELS + 2u]; // of smooth lines, at the pixels' edges
static uint8_t seen_waypoints;
static uint8_t whole_pixels;
static uint32_t starts[3]; // of the newest loaded periods, the newest first
static int32_t steps_loaded;
static uint16_t lags;    // accounts that waited outside a batch or a pixel
static uint16_t awaited; // steps while a whole pixel waited for one of two trains
static uint16_t singles; // steps while a pixel was written step by step
static uint8_t stagger;  // steps in front of a pixel's train

void setUp(void)
{
    promise_broken = 0;
    chance_seed(0x5EED0F15uL);
    stagger = 0;
}

void tearDown(void)
{
    TEST_ASSERT_EQUAL_UINT16(0, promise_broken);
}

// Place of the end of pixel k, floor(k * P), ticks.
static uint32_t edge_of(uint8_t k)
{
    uint64_t parts = (uint64_t)bench.period.whole_ticks * bench.period.divisor +
                     bench.period.remainder;

    return (uint32_t)(k * parts / bench.period.divisor);
}

// The first whole tick at which a pixel of `ticks` ticks has made `step` of its steps.
static uint32_t tick_of(uint32_t ticks, uint16_t step, uint16_t steps, uint16_t speed)
{
    int64_t length = ticks;
    int64_t half = (int64_t)steps - speed;
    uint32_t low = 0;
    uint32_t high = ticks;

    while (low < high) {
        uint32_t t = low + (high - low) / 2u;
        int64_t made = speed * length * t + half * t * t;
        if (made >= step * length * length) {
            high = t;
        } else {
            low = t + 1u;
        }
    }
    return low;
}

// Queue the pixels from number i on that the next entry has, in one of its forms. Returns how many.
// last: the count of the entry before. runs: equal counts in one entry are allowed.
static uint8_t queue_entry(uint8_t i, int16_t last, bool runs)
{
    int16_t change = (int16_t)(counts[i] - last);
    uint8_t same = 1;
    uint8_t bytes[2];

    while (same < 7u && i + same < pixels && counts[i + same] == counts[i]) {
        same++;
    }
    switch (chance_between(0, 3)) {
    case 0:
        TEST_ASSERT_EQUAL(BLOCK_TAKEN, bench_queue(counts[i], 1));
        return 1;
    case 1:
        if (!runs || same == 1u || change < -128 || change > 127) {
            break;
        }
        bytes[0] = (uint8_t)(SEGMENT_SHORT_RUN + same);
        bytes[1] = (uint8_t)change;
        TEST_ASSERT_EQUAL(BLOCK_TAKEN,
                          bench_queue_block(bench.axis.next_block, bytes, 2, true));
        return same;
    default:
        break;
    }
    if (change < -56 || change > 56) {
        TEST_ASSERT_EQUAL(BLOCK_TAKEN, bench_queue(counts[i], 1));
    } else {
        bytes[0] = (uint8_t)((int16_t)SEGMENT_NEAR_ZERO + change);
        TEST_ASSERT_EQUAL(BLOCK_TAKEN,
                          bench_queue_block(bench.axis.next_block, bytes, 1, true));
    }
    return 1;
}

static void queue_start(bool smooth)
{
    uint16_t word = LINE_MARK_START | LINE_START_WAIT | (smooth ? LINE_START_SMOOTH : 0u);

    TEST_ASSERT_EQUAL(BLOCK_TAKEN, bench_queue((int16_t)word, 0));
    TEST_ASSERT_EQUAL(BLOCK_TAKEN, bench_queue(0, 0));
}

static void queue_line(bool smooth)
{
    queue_start(smooth);
    int16_t last = 0;
    for (uint8_t i = 0; i < pixels;) {
        uint8_t queued = queue_entry(i, last, !smooth);
        last = counts[i];
        i = (uint8_t)(i + queued);
    }
    TEST_ASSERT_EQUAL(BLOCK_TAKEN, bench_queue((int16_t)LINE_MARK_END, 0));
}

// A clock edge in one of the newest periods gets its time, wherever the account stands, and even if
// the handler saw one period more: when only the older period is as long as the count. Periods of a
// train differ by one tick, and its reader does not tell them apart.
static void check_capture(const struct engine_sample *sample)
{
    struct axis *axis = &bench.axis;
    uint8_t back = (uint8_t)chance_between(0, 2);
    uint8_t seen = back;
    uint32_t captured_ticks = 7;

    if (back == 2) {
        uint32_t newer_ticks = starts[0] - starts[1];
        uint32_t ticks = starts[1] - starts[2];
        if (ticks > newer_ticks + 1u) {
            seen = 1;
            captured_ticks = chance_between(newer_ticks + 1u, ticks - 1u);
        }
    }
    TEST_ASSERT_EQUAL_UINT32(
        starts[back] + captured_ticks,
        ledger_advance_to_capture(
            &axis->ledger, &axis->feed.stream, sample, seen, (uint16_t)captured_ticks));
}

// An account by waypoints tells where the axis is, too.
static void check_waypoints(const struct engine_sample *sample)
{
    struct axis *axis = &bench.axis;

    ledger_advance(&axis->ledger, &axis->feed.stream, sample, LEDGER_BY_WAYPOINTS);
    TEST_ASSERT_EQUAL_INT32(
        steps_loaded,
        ledger_position_at(&axis->ledger, &axis->feed.stream, sample->tail));
    if (axis->feed.stream.retired != sample->tail) {
        lags++;
    }
}

// Count the pixels that can be accounted for as a whole.
static void count_whole_pixels(void)
{
    const struct stream *stream = &bench.axis.feed.stream;

    for (; seen_waypoints != stream->waypoint_placed; seen_waypoints++) {
        if (waypoint_is_plain(
                &stream->waypoints[seen_waypoints & (STREAM_WAYPOINTS - 1u)])) {
            whole_pixels++;
        }
    }
}

// The account lags, comes up, or places an edge.
static void follow(void)
{
    struct axis *axis = &bench.axis;
    struct engine_sample sample = step_engine_sample(&bench.engine);
    uint32_t what = chance_between(0, 9);

    if (what < 4) {
        if (ledger_due(&axis->ledger, &axis->feed.stream, &sample)) {
            ledger_advance(
                &axis->ledger, &axis->feed.stream, &sample, LEDGER_BY_WAYPOINTS);
        }
    } else if (what == 4) {
        ledger_advance(&axis->ledger, &axis->feed.stream, &sample, LEDGER_EXACTLY);
        if (axis->ledger.train == LEDGER_NO_TRAIN) {
            TEST_ASSERT_EQUAL_UINT32(bench.now_ticks, axis->ledger.loaded_ticks);
        }
    } else if (what == 5) {
        check_capture(&sample);
    } else if (what == 6) {
        check_waypoints(&sample);
    } else if (what == 7) {
        (void)ledger_advance_plain(&axis->ledger, &axis->feed.stream, sample.tail);
    }
}

// Load periods up to the next STEP edge. Returns its tick of the line.
static uint32_t next_edge(void)
{
    for (uint16_t i = 0; i < 1000; i++) {
        starts[2] = starts[1];
        starts[1] = starts[0];
        starts[0] = bench.now_ticks;
        decode_axis(&bench.axis, &bench.period, 30);
        count_whole_pixels();
        if (bench.axis.phase == DECODE_PIXEL_AWAITS_TRAIN) {
            awaited++;
        }
        if (bench.axis.phase == DECODE_PIXEL_SINGLES) {
            singles++;
        }
        struct step_load load = step_engine_next(&bench.engine, &bench.ring);
        bench.now_ticks += (uint32_t)load.top_ticks + 1u;
        if (load.pulse) {
            steps_loaded += bench.engine.negative ? -1 : 1;
        }
        follow();
        if (load.pulse) {
            return starts[0] - bench.zero_ticks;
        }
    }
    TEST_FAIL_MESSAGE("no edge");
    return 0;
}

static void begin_line(void)
{
    starts[0] = bench.now_ticks - STEP_IDLE_TICKS;
    starts[1] = starts[0] - STEP_IDLE_TICKS;
    seen_waypoints = 0;
    whole_pixels = 0;
    steps_loaded = 0;
    lags = 0;
    awaited = 0;
    TEST_ASSERT_TRUE(bench_start_line());
}

// Run the line and look at every edge.
static void run_line(bool smooth)
{
    begin_line();
    for (uint8_t i = 0; i < pixels; i++) {
        uint16_t steps = (uint16_t)(counts[i] < 0 ? -counts[i] : counts[i]);
        uint32_t start = edge_of(i);
        uint32_t ticks = edge_of((uint8_t)(i + 1u)) - start;
        for (uint16_t step = 1; step <= steps; step++) {
            uint32_t place =
                start + tick_of(ticks, step, steps, smooth ? speeds[i] : steps);
            TEST_ASSERT_EQUAL_UINT32(place, next_edge());
        }
    }
    while (!bench_finish_line()) {
        (void)bench_period();
    }
}

static void check_records(void)
{
    const struct records *records = &bench.axis.ledger.records;

    TEST_ASSERT_EQUAL_UINT32(pixels, bench.axis.ledger.pixel);
    for (uint8_t i = 0; i < records->count; i++) {
        struct pixel_record record = records_get(records, i);
        int32_t sum = 0;
        for (uint16_t k = 0; k < record.pixel; k++) {
            sum += counts[k];
        }
        TEST_ASSERT_EQUAL_INT32(sum, record.actual_steps);
        TEST_ASSERT_EQUAL_INT32(sum, record.expected_steps);
    }
}

static void check_line(uint32_t hz_num, uint32_t hz_den, bool smooth, uint8_t whole)
{
    bench_open(hz_num, hz_den);
    bench_stagger(stagger);
    queue_line(smooth);
    run_line(smooth);
    TEST_ASSERT_TRUE(whole_pixels >= whole);
    check_records();
}

static void random_counts(uint16_t least, uint16_t most)
{
    pixels = PIXELS;
    for (uint8_t i = 0; i < pixels; i++) {
        counts[i] = (int16_t)chance_between(least, most);
    }
}

static void plain_pixels_of_all_lengths(void)
{
    random_counts(1, 20);
    check_line(5000, 1, false, PIXELS - 8u);
    random_counts(1, 60);
    check_line(1000, 1, false, PIXELS - 8u);
    random_counts(10, 20);
    check_line(100013, 50, false, PIXELS - 8u);
    random_counts(1, 64);
    check_line(
        29970, 121, false, 0); // 247.7 Hz: longer than 2^16 ticks, so not as a whole
    random_counts(1, 64);
    check_line(7000, 93, false, 0);
    random_counts(1, EVEN_PIXEL_MAX_STEPS);
    check_line(1000, 1, false, PIXELS - 8u);
    random_counts(61, EVEN_PIXEL_MAX_STEPS);
    check_line(29970, 31, false, PIXELS - 8u);
}

static void backwards(void)
{
    for (uint8_t i = 0; i < pixels; i++) {
        counts[i] = (int16_t)-counts[i];
    }
}

// Positions below zero, and counts whose high byte is not 0, go the same ways.
static void plain_pixels_backwards(void)
{
    random_counts(1, 20);
    backwards();
    check_line(5000, 1, false, PIXELS - 8u);
    random_counts(1, 60);
    backwards();
    check_line(1000, 1, false, PIXELS - 8u);
    random_counts(61, EVEN_PIXEL_MAX_STEPS);
    backwards();
    check_line(29970, 31, false, PIXELS - 8u);
}

// The decoder comes no more: the ring runs dry inside the pixel that was written last, and the
// axis halts. Edges of the clock that come then are placed by its idle periods.
static void clock_edges_behind_a_ring_that_ran_dry(void)
{
    for (uint8_t i = 0; i < 40u; i++) {
        random_counts(5, 20);
        bench_open(2000, 1);
        queue_line(false);
        begin_line();
        for (uint16_t edges = (uint16_t)chance_between(20, 200); edges != 0; edges--) {
            (void)next_edge();
        }
        uint8_t idle = 0;
        while (idle < 6u) {
            struct step_load load = step_engine_next(&bench.engine, &bench.ring);
            starts[2] = starts[1];
            starts[1] = starts[0];
            starts[0] = bench.now_ticks;
            bench.now_ticks += (uint32_t)load.top_ticks + 1u;
            idle = (uint8_t)(idle + (load.idle ? 1u : 0u));
            struct engine_sample sample = step_engine_sample(&bench.engine);
            if (chance_between(0, 1) != 0) {
                check_capture(&sample);
            }
        }
    }
}

// A clock edge may be three periods old when its handler comes to look, also where a train has
// ended and the axis rests: its place is known to a tick.
static void a_clock_edge_that_is_seen_late_behind_a_train(void)
{
    uint32_t began[5] = {0};
    uint8_t idle = 0;

    pixels = 3;
    for (uint8_t i = 0; i < pixels; i++) {
        counts[i] = 125;
    }
    bench_open(1000, 1);
    queue_line(false);
    begin_line();
    while (idle < 1u) {
        for (uint8_t i = 4; i != 0; i--) {
            began[i] = began[i - 1u];
        }
        began[0] = bench.now_ticks;
        decode_axis(&bench.axis, &bench.period, 30);
        struct step_load load = step_engine_next(&bench.engine, &bench.ring);
        bench.now_ticks += (uint32_t)load.top_ticks + 1u;
        idle = (uint8_t)(idle + (load.idle ? 1u : 0u));
        struct engine_sample sample = step_engine_sample(&bench.engine);
        if (began[4] == 0) {
            continue;
        }
        for (uint8_t back = 0; back <= 3u; back++) {
            uint32_t placed = ledger_advance_to_capture(
                &bench.axis.ledger, &bench.axis.feed.stream, &sample, back, 7);
            TEST_ASSERT_UINT32_WITHIN(1, began[back] + 7u, placed);
        }
    }
    TEST_ASSERT_EQUAL_UINT32(pixels, bench.axis.ledger.pixel);
    while (!bench_finish_line()) {
        (void)bench_period();
    }
}

static void one_count(int16_t count, uint32_t numerator, uint32_t divisor)
{
    pixels = PIXELS;
    for (uint8_t i = 0; i < pixels; i++) {
        counts[i] = count;
    }
    check_line(numerator, divisor, false, PIXELS - 8u);
}

static void one_count_for_all(void)
{
    for (int16_t count = 1; count <= 21; count += 4) {
        one_count(count, 14997, 3);
    }
    // What is left of the ring is more than a round of decoding asks for, and less than a pixel
    // does: the line begins all the same.
    for (int16_t count = 65; count <= (int16_t)EVEN_PIXEL_MAX_STEPS; count += 5) {
        one_count(count, 1000, 1);
    }
}

// The quotient of 2 steps is kept where that of 18 is, and at this period 18 times that quotient is
// 2^16 more than the pixel.
static void pixels_whose_quotients_are_kept_in_one_place(void)
{
    static const int16_t kinds[] = {2, 18, 34, 66, 18, 2, 50, 114, 2, 98, 18, 16, 32, 2};

    pixels = sizeof(kinds) / sizeof(kinds[0]);
    for (uint8_t i = 0; i < pixels; i++) {
        counts[i] = kinds[i];
    }
    check_line(15625, 8, false, 1);
    check_line(1000, 1, false, 1);
}

static uint16_t run_pixels;

// Steps of the pixels of a_run_of_many_pixels().
static uint16_t steps_of(uint16_t pixel)
{
    if (pixel == 0) {
        return 3;
    }
    return pixel <= run_pixels ? 2u : 5u;
}

static void check_edges(uint32_t start, uint32_t end, uint16_t steps)
{
    for (uint16_t step = 1; step <= steps; step++) {
        TEST_ASSERT_EQUAL_UINT32(start + tick_of(end - start, step, steps, steps),
                                 next_edge());
    }
}

// Run pixels of 3 steps, of 2, and of 5.
static void run_between(uint32_t hz_num, uint32_t hz_den)
{
    uint64_t place = 0;
    uint32_t start = 0;

    bench_open(hz_num, hz_den);
    queue_start(false);
    TEST_ASSERT_EQUAL(BLOCK_TAKEN, bench_queue(3, 1));
    TEST_ASSERT_EQUAL(BLOCK_TAKEN, bench_queue(2, run_pixels));
    TEST_ASSERT_EQUAL(BLOCK_TAKEN, bench_queue(5, 1));
    TEST_ASSERT_EQUAL(BLOCK_TAKEN, bench_queue((int16_t)LINE_MARK_END, 0));
    begin_line();
    for (uint16_t pixel = 0; pixel < run_pixels + 2u; pixel++) {
        place += (uint64_t)bench.period.whole_ticks * bench.period.divisor +
                 bench.period.remainder;
        uint32_t end = (uint32_t)(place / bench.period.divisor);
        check_edges(start, end, steps_of(pixel));
        start = end;
    }
    while (!bench_finish_line()) {
        (void)bench_period();
    }
    TEST_ASSERT_EQUAL_UINT32(run_pixels + 2u, bench.axis.ledger.pixel);
}

// A run of more pixels than are counted at a time, at a period of whole ticks, with a fraction in
// 16 bits, and in more.
static void a_run_of_many_pixels(void)
{
    static const uint16_t runs[] = {1, 254, 255, 256, 511, 600};

    for (uint8_t i = 0; i < (uint8_t)(sizeof(runs) / sizeof(runs[0])); i++) {
        run_pixels = runs[i];
        run_between(5000, 1);
        run_between(4999, 1);
        run_between(5000001, 1001);
    }
}

// Few even steps, too many of them, none, reversals, and few again.
static void pixels_of_every_kind_in_turn(void)
{
    static const int16_t kinds[] = {
        3, 4, 125, 125, 5, 0, 0, 2, 12, -3, -7, -122, -1, 9, 9, 120, 121};

    pixels = sizeof(kinds) / sizeof(kinds[0]);
    for (uint8_t i = 0; i < pixels; i++) {
        counts[i] = kinds[i];
    }
    check_line(1000, 1, false, 1);
    check_line(333, 1, false, 0);
}

// An interval that is too long for a single period, or too short, behind short pixels: the next
// pixel of as many steps must not take it for that of the last one.
static void an_interval_that_was_refused_is_not_kept(void)
{
    for (uint8_t steps = 1; steps <= 4u; steps++) {
        pixels = 12;
        for (uint8_t i = 0; i < pixels; i++) {
            counts[i] = (int16_t)(i % 6u < 3u ? 5 * steps : steps);
        }
        for (uint8_t more = 0; more <= 8u; more++) {
            // From 64000 to 66000 ticks a step, at 16 MHz.
            check_line(64000, steps * (256u + more), false, 0);
        }
    }
    pixels = 12;
    for (uint8_t i = 0; i < pixels; i++) {
        counts[i] = i % 6u < 3u ? 20 : 63;
    }
    check_line(2000, 1, false, 0);
}

// Boundary speeds up to `top`, back to rest and up again, each pixel changing by up to 2 * half.
static void ramps(uint16_t top, uint16_t half)
{
    uint16_t speed = 0;
    bool up = true;

    pixels = 0;
    speeds[0] = 0;
    while (pixels < PIXELS - 1u || (speed != 0 && pixels < PIXELS)) {
        uint16_t change = (uint16_t)(2u * chance_between(0, half));
        if (pixels >= PIXELS / 2u && speed <= change) {
            break;
        }
        up = speed == 0 || (up && speed + change < top);
        if (!up && change > speed) {
            change = speed;
        }
        uint16_t next = (uint16_t)(up ? speed + change : speed - change);
        counts[pixels] = (int16_t)((speed + next) / 2u);
        speed = next;
        pixels++;
        speeds[pixels] = speed;
    }
    while (speed != 0 && pixels <= PIXELS) {
        counts[pixels] = (int16_t)(speed / 2u);
        speed = 0;
        pixels++;
        speeds[pixels] = 0;
    }
}

static void smooth_pixels_speed_up_and_slow_down(void)
{
    ramps(20, 1);
    check_line(5000, 1, true, 8);
    ramps(60, 4);
    check_line(1000, 1, true, 8);
    ramps(60, 10);
    check_line(100013, 125, true, 8);
    ramps(60, 8);
    check_line(30, 1, true, 0);
}

// Hundreds of steps a pixel: they come in batches.
static void the_account_waits_outside_batches(void)
{
    ramps(400, 40);
    check_line(30, 1, true, 0);
    TEST_ASSERT_TRUE(lags > 50u);
}

// Intervals of 256 k and 256 k + 1 ticks: no pulse train can make them, and such pixels are written
// step by step, in any direction, between others.
static void pixels_that_no_train_can_make(void)
{
    static const int16_t kinds[] = {
        312, 312, 312, 3, 312, 300, 312, 312, 0, 312, 3, -3, -312, -312, -250};

    pixels = sizeof(kinds) / sizeof(kinds[0]);
    for (uint8_t i = 0; i < pixels; i++) {
        counts[i] = kinds[i];
    }
    singles = 0;
    for (stagger = 0; stagger <= 6u; stagger = (uint8_t)(stagger + 2u)) {
        check_line(100, 1, false, 0);
    }
    TEST_ASSERT_TRUE(!SEVERAL_AXES || singles > 1000u);
    stagger = 0;
    // Longer than a single period: by way of pieces.
    singles = 0;
    pixels = 3;
    counts[2] = 125;
    counts[1] = 125;
    counts[0] = 125;
    check_line(1, 1, false, 0);
    // Behind ones that are whole.
    counts[1] = 300;
    counts[0] = 300;
    check_line(1, 1, false, 0);
    // 256 ticks each: a train.
    pixels = 13;
    for (uint8_t i = 0; i < pixels; i++) {
        counts[i] = 125;
    }
    check_line(500, 1, false, 0);
    TEST_ASSERT_EQUAL_UINT16(0, singles);
}

// Pixels of many steps are a pulse train each, behind single steps that keep the trains of several
// axes apart.
static void pixels_of_many_even_steps(void)
{
    for (stagger = 0; stagger <= 6u; stagger = (uint8_t)(stagger + 2u)) {
        random_counts(65, 400);
        check_line(30, 1, false, 0);
        TEST_ASSERT_TRUE(!SEVERAL_AXES || awaited > 1000u);
        random_counts(65, 66);
        check_line(100013, 125, false, 0);
    }
}

// Intervals on both sides of the shortest one behind which a train may begin, and of 256 ticks and
// their multiples, where a train cannot have both of its intervals; and some so long that the end
// of a train is not waited for.
static void pixels_of_many_steps_and_awkward_intervals(void)
{
    static const int16_t awkward[] = {
        416, 416, 400, 417, 416, 260, 261, 259, 130, 131, 130, 65, 66, 66, 400, 400};

    pixels = sizeof(awkward) / sizeof(awkward[0]);
    for (stagger = 0; stagger <= 6u; stagger = (uint8_t)(stagger + 6u)) {
        for (uint8_t i = 0; i < pixels; i++) {
            counts[i] = awkward[i];
        }
        check_line(240, 1, false, 0);
        check_line(30, 1, false, 0);
    }
}

// The most entries that such a pixel can have, when the ring is nearly full of single periods.
static void a_pixel_of_the_most_steps_behind_a_full_ring(void)
{
    stagger = 6;
    pixels = 24;
    for (int16_t few = 17; few <= 24; few++) {
        for (uint8_t i = 0; i < pixels; i++) {
            counts[i] = few;
        }
        counts[20] = (int16_t)TRAIN_PIXEL_MAX_STEPS;
        check_line(29, 1, false, 0);
    }
}

// A smooth line turns from acceleration to even pixels and back.
static void smooth_pixels_of_many_steps(void)
{
    stagger = 4;
    ramps(300, 1);
    check_line(30, 1, true, 0);
    ramps(500, 60);
    check_line(60, 1, true, 0);
}

static struct stream stream;
static struct line line;

// Write a pixel of 20 steps of 5000 ticks behind what ends at this tick, and where so many slots
// are taken.
static void write_behind(uint32_t end_ticks, uint8_t taken)
{
    static struct segment_queue queue;
    static uint8_t bytes[16];
    static struct pixel_period period;
    static struct step_ring ring;

    period = (struct pixel_period){.whole_ticks = 100000uL, .divisor = 1};
    queue = (struct segment_queue){.out = {.bytes = bytes, .mask = 15, .last = 20},
                                   .head = 1};
    bytes[0] = SEGMENT_NEAR_ZERO;
    line = (struct line){.source = {.queue = &queue, .edge_open = true}};
    line.source.segment = (struct segment){.count = 20};
    line_grid_start_exact(&line.edges, &period);
    stream = (struct stream){.ring = &ring, .waypoint_head = 1, .end_ticks = end_ticks};
    stream.head = taken;
    (void)even_pixels_write(&line, &stream, false, UINT8_MAX);
}

static uint32_t end_behind(uint32_t end_ticks)
{
    write_behind(end_ticks, 0);
    TEST_ASSERT_EQUAL_UINT8(20, stream.head);
    return stream.end_ticks;
}

// It waits for the room of all its steps, and says so.
static void a_pixel_waits_for_its_room(void)
{
    for (uint8_t taken = 200; taken <= STEP_RING_CAPACITY; taken++) {
        bool waits = STEP_RING_CAPACITY - taken < 20;

        write_behind(1000, taken);
        TEST_ASSERT_EQUAL_UINT8(waits ? taken : (uint8_t)(taken + 20u), stream.head);
        TEST_ASSERT_EQUAL_UINT8(waits ? 20 : 0, line.room);
        if (taken == UINT8_MAX) {
            break;
        }
    }
}

// Times have 32 bits, and a pixel may be longer than 16.
static void ends_of_long_pixels(void)
{
    static const uint32_t before_ticks[] = {0,
                                            0xFFFFuL,
                                            0xFE0000uL,
                                            0xFE795FuL,
                                            0xFE7960uL,
                                            0xFF0000uL,
                                            0x12FFFFFFuL,
                                            0xFFFFFF00uL};

    for (size_t i = 0; i < sizeof before_ticks / sizeof before_ticks[0]; i++) {
        TEST_ASSERT_EQUAL_UINT32(before_ticks[i] + 100000uL, end_behind(before_ticks[i]));
    }
}

// Whatever its reciprocal, a pixel's interval is the quotient, with the rest that belongs to it:
// the longest pixels are those that a reciprocal suits worst.
static void every_count_of_steps_divides_exactly(void)
{
    for (uint8_t steps = 1; steps <= EVEN_PIXEL_MAX_STEPS; steps++) {
        for (uint16_t less = 0; less <= 2u * steps; less++) {
            uint16_t ticks = (uint16_t)(UINT16_MAX - less);
            struct even_rate rate = {0};

            if (even_pixel_divide(&rate, steps, ticks)) {
                TEST_ASSERT_EQUAL_UINT16(ticks / steps, rate.base_ticks);
                TEST_ASSERT_EQUAL_UINT8(ticks % steps, rate.remainder);
            }
            TEST_ASSERT_EQUAL(steps > 1, rate.steps == steps);
        }
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(every_count_of_steps_divides_exactly);
    RUN_TEST(plain_pixels_of_all_lengths);
    RUN_TEST(plain_pixels_backwards);
    RUN_TEST(clock_edges_behind_a_ring_that_ran_dry);
    RUN_TEST(a_clock_edge_that_is_seen_late_behind_a_train);
    RUN_TEST(one_count_for_all);
    RUN_TEST(pixels_whose_quotients_are_kept_in_one_place);
    RUN_TEST(a_run_of_many_pixels);
    RUN_TEST(pixels_of_every_kind_in_turn);
    RUN_TEST(an_interval_that_was_refused_is_not_kept);
    RUN_TEST(smooth_pixels_speed_up_and_slow_down);
    RUN_TEST(the_account_waits_outside_batches);
    RUN_TEST(pixels_that_no_train_can_make);
    RUN_TEST(pixels_of_many_even_steps);
    RUN_TEST(pixels_of_many_steps_and_awkward_intervals);
    RUN_TEST(a_pixel_of_the_most_steps_behind_a_full_ring);
    RUN_TEST(smooth_pixels_of_many_steps);
    RUN_TEST(ends_of_long_pixels);
    RUN_TEST(a_pixel_waits_for_its_room);
    return UNITY_END();
}
