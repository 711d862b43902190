// SPDX-License-Identifier: MIT
// Edges of the pixel clock in pixels of few even steps: what the quick way makes of an edge is
// compared with what the general way makes of it, from the same account and the same plan. The
// quick way must have taken most edges that are near, and none that is not.
#include <stdint.h>
#include <string.h>

#include "account/near_edge.h"
#include "axis/decode.h"
#include "fakes/axis_bench.h"
#include "fakes/chance.h"
#include "unity.h"

#if SEVERAL_AXES && FEATURE_CLOCK_STATISTICS

#define PIXELS 60u
#define KEPT   4u // periods

static uint32_t starts[KEPT];     // of the newest loaded periods, the newest first
static struct pixel_period clock; // of its edges
static struct clock_watch watch;
static struct pixel_grid plan;
static uint32_t edge_ticks;  // of the next edge of the clock, by the plan
static int32_t off_ticks;    // it comes so much later
static bool trains;          // which must become free in time
static int32_t drift_ticks;  // by which each edge comes later than the one before
static uint16_t edges;       // that came,
static uint16_t near_edges;  // that were near,
static uint16_t taken_edges; // and that the quick way took

void setUp(void)
{
    chance_seed(0x4EA2ED6EuL);
    trains = false;
    drift_ticks = 0;
    edges = 0;
    near_edges = 0;
    taken_edges = 0;
}

void tearDown(void)
{
}

static void load_period(void)
{
    for (uint8_t i = KEPT - 1u; i != 0; i--) {
        starts[i] = starts[i - 1u];
    }
    starts[0] = bench.now_ticks;
    (void)decode_axis(&bench.axis, &bench.period, 60);
    struct step_load load = step_engine_next(&bench.engine, &bench.ring);
    bench.now_ticks += (uint32_t)load.top_ticks + 1u;
}

// The edge that falls into one of the periods that the timer has begun, as its handler leaves it.
static bool captured(struct captured_edge *edge)
{
    uint32_t at = edge_ticks + (uint32_t)off_ticks + CAPTURED_EDGE_DELAY_TICKS;

    for (uint8_t back = 1; back < KEPT - 1u; back++) {
        uint32_t into_ticks = at - starts[back];
        if (into_ticks < starts[back - 1u] - starts[back]) {
            struct engine_sample sample = step_engine_sample(&bench.engine);
            *edge = (struct captured_edge){
                .ticks = (uint16_t)into_ticks,
                .tail = sample.tail,
                .left_or_cut =
                    (int8_t)(sample.train ? -(int8_t)sample.left : sample.left),
                .idle_count = sample.idle_count,
                .notes = (uint8_t)(back | (sample.cut ? CAPTURED_EDGE_CUT : 0)),
            };
            return true;
        }
    }
    return false;
}

static bool is_near(void)
{
    int32_t near_ticks = watch.near_ticks;

    int32_t change_ticks = off_ticks - watch.error_ticks;

    return watch.near && off_ticks >= -16 * near_ticks && off_ticks <= 16 * near_ticks &&
           change_ticks >= -near_ticks && change_ticks <= near_ticks;
}

// Take the edge both ways, from copies of the account and of the watch.
static void take(const struct captured_edge *edge)
{
    static struct ledger ledger;
    static struct stream stream;
    struct clock_watch general = watch;
    struct clock_watch before = watch;
    struct engine_sample sample = step_engine_sample(&bench.engine);
    uint16_t pixel = 0;

    ledger = bench.axis.ledger;
    stream = bench.axis.feed.stream;
    uint32_t ticks =
        ledger_advance_to_capture(
            &ledger, &stream, &sample, edge->notes & CAPTURED_EDGE_BACK, edge->ticks) -
        CAPTURED_EDGE_DELAY_TICKS;
    TEST_ASSERT_EQUAL_UINT32(edge_ticks + (uint32_t)off_ticks, ticks);
    bool of_pixel = clock_watch_edge(&general, &clock, ticks, &pixel);
    bool near = is_near();
    struct near_edge result =
        near_edge_take(edge, &bench.axis.ledger, &bench.axis.feed.stream, &watch);

    edges++;
    near_edges = (uint16_t)(near_edges + near);
    TEST_ASSERT_TRUE(near || !result.taken);
    if (!result.taken) {
        TEST_ASSERT_EQUAL_MEMORY(&before, &watch, sizeof watch);
        watch = general;
        bench.axis.ledger = ledger;
        bench.axis.feed.stream = stream;
        return;
    }
    taken_edges++;
    TEST_ASSERT_EQUAL_MEMORY(&general, &watch, sizeof watch);
    TEST_ASSERT_EQUAL(of_pixel, result.of_pixel);
    if (of_pixel) {
        TEST_ASSERT_EQUAL_UINT16(pixel, result.pixel);
    }
}

// Line zero is known; the edges before it are none of the line's.
static void begin(uint32_t hz_num, uint32_t hz_den, uint16_t divider)
{
    TEST_ASSERT_TRUE(bench_start_line());
    TEST_ASSERT_TRUE(pixel_period_set(&clock, 16000000uL, hz_num * divider, hz_den));
    memset(&watch, 0, sizeof watch);
    watch.divider = divider;
    clock_watch_follow(&watch, &clock, bench.zero_ticks);
    // As behind an edge that was near.
    watch.known = true;
    watch.near = true;
    watch.edge_ticks = bench.zero_ticks - clock.whole_ticks;
    pixel_grid_start(&plan, &clock);
    edge_ticks = bench.zero_ticks;
    for (uint8_t i = 0; i < KEPT; i++) {
        starts[i] = bench.now_ticks - STEP_IDLE_TICKS * (uint32_t)(i + 1u);
    }
}

// The account lags until an edge comes, but now and then, and where trains must become free.
static void follow(void)
{
    struct axis *axis = &bench.axis;
    struct engine_sample sample = step_engine_sample(&bench.engine);
    uint32_t what = chance_between(0, 200);

    if (what == 0) {
        ledger_advance(&axis->ledger, &axis->feed.stream, &sample, LEDGER_EXACTLY);
    } else if (what == 1 ||
               (trains && ledger_due(&axis->ledger, &axis->feed.stream, &sample))) {
        ledger_advance(&axis->ledger, &axis->feed.stream, &sample, LEDGER_BY_BATCHES);
    }
}

// Lines whose pixels have from `least` to `most` steps. The clock's edges are off by up to `spread`
// ticks, one in eight by more than is near.
static void run(uint32_t hz_num,
                uint32_t hz_den,
                uint16_t divider,
                int16_t least,
                int16_t most,
                uint16_t spread)
{
    struct captured_edge edge;

    bench_open(hz_num, hz_den);
    TEST_ASSERT_EQUAL(BLOCK_TAKEN,
                      bench_queue((int16_t)(LINE_MARK_START | LINE_START_WAIT), 0));
    TEST_ASSERT_EQUAL(BLOCK_TAKEN, bench_queue(0, 0));
    for (uint8_t i = 0; i < PIXELS; i++) {
        int16_t count = (int16_t)chance_between((uint16_t)least, (uint16_t)most);
        TEST_ASSERT_EQUAL(BLOCK_TAKEN, bench_queue(count, 1));
    }
    TEST_ASSERT_EQUAL(BLOCK_TAKEN, bench_queue((int16_t)LINE_MARK_END, 0));
    begin(hz_num, hz_den, divider);
    off_ticks = 0;
    for (uint16_t left = PIXELS * divider; left != 0;) {
        load_period();
        TEST_ASSERT_TRUE((int32_t)(bench.now_ticks - edge_ticks) < 100000);
        if (!captured(&edge)) {
            follow();
            continue;
        }
        take(&edge);
        left--;
        edge_ticks += pixel_grid_advance(&plan);
        uint16_t most_ticks =
            chance_between(0, 7) == 0 ? (uint16_t)(3u * watch.near_ticks / 2u) : spread;
        off_ticks = (int32_t)chance_between(0, 2u * most_ticks) - most_ticks;
        off_ticks += drift_ticks * (int32_t)(PIXELS * divider - left);
    }
    while (!bench_finish_line()) {
        (void)bench_period();
    }
}

static void edges_of_pixels(void)
{
    run(2000, 1, 1, 10, 20, 3);
    run(1750, 1, 1, 10, 20, 40);
    run(1000003, 700, 1, 5, 30, 100);
    run(5000, 1, 1, 2, 20, 5);
    TEST_ASSERT_EQUAL_UINT16(4u * PIXELS, edges);
    TEST_ASSERT_GREATER_OR_EQUAL_UINT16(edges * 3u / 4u, near_edges);
    TEST_ASSERT_LESS_THAN_UINT16(edges, near_edges);
    // All but those where the line begins, or where the account was inside a pixel.
    TEST_ASSERT_GREATER_OR_EQUAL_UINT16(near_edges * 4u / 5u, taken_edges);
}

// A clock that is off takes its edges further and further from the plan of a line that only begins
// on it. That is no reason for the long way.
static void edges_of_a_clock_that_is_off(void)
{
    drift_ticks = 40; // 5000 ppm
    run(2000, 1, 1, 10, 20, 3);
    drift_ticks = -40;
    run(2000, 1, 1, 10, 20, 3);
    TEST_ASSERT_EQUAL_UINT16(2u * PIXELS, edges);
    TEST_ASSERT_GREATER_OR_EQUAL_UINT16(edges * 2u / 3u, near_edges);
    TEST_ASSERT_GREATER_OR_EQUAL_UINT16(near_edges * 4u / 5u, taken_edges);
}

static void edges_inside_pixels(void)
{
    run(500, 1, 4, 20, 40, 3);
    run(300, 1, 5, 60, 100, 30);
    TEST_ASSERT_EQUAL_UINT16((4u + 5u) * PIXELS, edges);
    TEST_ASSERT_GREATER_OR_EQUAL_UINT16(near_edges / 2u, taken_edges);
}

// Trains and curves have no pixels of the quick way's kind.
static void edges_beside_trains(void)
{
    trains = true;
    run(100, 1, 1, 600, 700, 3);
    TEST_ASSERT_EQUAL_UINT16(PIXELS, edges);
    TEST_ASSERT_LESS_THAN_UINT16(PIXELS / 4u, taken_edges);
}

// What the handler says otherwise, the general way looks into.
static void a_parked_axis_and_a_cut_train(void)
{
    struct captured_edge edge = {.ticks = 100, .notes = 1};

    bench_open(2000, 1);
    memset(&watch, 0, sizeof watch);
    watch.following = true;
    watch.near = true;
    watch.near_ticks = 200;
    pixel_grid_start(&watch.grid, &bench.period);
    edge.notes = 1 | CAPTURED_EDGE_WAS_PARKED;
    TEST_ASSERT_FALSE(
        near_edge_take(&edge, &bench.axis.ledger, &bench.axis.feed.stream, &watch).taken);
    edge.notes = 1 | CAPTURED_EDGE_CUT;
    TEST_ASSERT_FALSE(
        near_edge_take(&edge, &bench.axis.ledger, &bench.axis.feed.stream, &watch).taken);
    edge.notes = 1;
    edge.idle_count = (uint16_t)(bench.axis.ledger.idle_seen + 1u);
    TEST_ASSERT_FALSE(
        near_edge_take(&edge, &bench.axis.ledger, &bench.axis.feed.stream, &watch).taken);
    TEST_ASSERT_EQUAL_UINT32(0, watch.edges);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(edges_of_pixels);
    RUN_TEST(edges_of_a_clock_that_is_off);
    RUN_TEST(edges_inside_pixels);
    RUN_TEST(edges_beside_trains);
    RUN_TEST(a_parked_axis_and_a_cut_train);
    return UNITY_END();
}

#else

void setUp(void)
{
}

void tearDown(void)
{
}

int main(void)
{
    UNITY_BEGIN();
    return UNITY_END();
}

#endif
