// SPDX-License-Identifier: MIT
// The play of an axis as a quantity: lines take up what is lacking of it, wherever the motor was
// stopped. A load behind the play judges, by the virtual interrupt's STEP edges alone.
#include <stdbool.h>
#include <stdint.h>

#include "axis/decode.h"
#include "fakes/axis_bench.h"
#include "fakes/promise.h"
#include "unity.h"

#define PLUS  (LINE_START_SMOOTH)
#define MINUS (LINE_START_SMOOTH | LINE_START_NEGATIVE)
#define PLAY  40

// Steps of the smooth line below, without the play.
#define WAY 240

static int32_t seen_steps; // of bench.steps
static int32_t motor;      // from the load: 0 pushes plus, -PLAY minus
static int32_t load;

void setUp(void)
{
    promise_broken = 0;
    bench_open(100, 1);
    seen_steps = 0;
    motor = -7; // nobody knows
    load = 0;
}

void tearDown(void)
{
    TEST_ASSERT_EQUAL_UINT16(0, promise_broken);
}

static void follow_load(void)
{
    int32_t moved = bench.steps - seen_steps;

    seen_steps = bench.steps;
    motor += moved;
    if (motor > 0) {
        load += motor;
        motor = 0;
    }
    if (motor < -PLAY) {
        load += motor + PLAY;
        motor = -PLAY;
    }
}

static void queue_smooth(uint16_t mark, int16_t play)
{
    static const int16_t counts[] = {20, 40, 40, 40, 40, 40, 20};

    TEST_ASSERT_EQUAL(BLOCK_TAKEN, bench_queue((int16_t)(LINE_MARK_START | mark), 0));
    TEST_ASSERT_EQUAL(BLOCK_TAKEN, bench_queue(play, 40));
    TEST_ASSERT_EQUAL(BLOCK_TAKEN, bench_queue(0, 1));
    for (size_t i = 0; i < sizeof counts / sizeof counts[0]; i++) {
        TEST_ASSERT_EQUAL(BLOCK_TAKEN, bench_queue(counts[i], 1));
    }
    TEST_ASSERT_EQUAL(BLOCK_TAKEN, bench_queue(0, 1));
    TEST_ASSERT_EQUAL(BLOCK_TAKEN, bench_queue(LINE_MARK_END, 0));
}

static void stop(void)
{
    uint8_t slot = 0;

    axis_stop(&bench.axis);
    step_engine_halt(&bench.engine);
    for (uint8_t i = 0; i < 3; i++) {
        TEST_ASSERT_FALSE(bench_period().pulse);
    }
    TEST_ASSERT_TRUE(step_engine_settle(&bench.engine, &bench.ring, &slot));
    axis_discard(&bench.axis, slot);
}

// Run the front line to its end, or so many steps far; then it is stopped.
static void run(int32_t most_steps)
{
    int32_t begun = bench.steps;

    TEST_ASSERT_TRUE(bench_start_line());
    while (!bench_finish_line()) {
        (void)bench_period();
        (void)ledger_settle_play(&bench.axis.ledger); // as the main loop does
        follow_load();
        int32_t made = bench.steps - begun;
        if (most_steps != 0 && (made < 0 ? -made : made) == most_steps) {
            stop();
            return;
        }
    }
}

static void run_smooth(uint16_t mark)
{
    queue_smooth(mark, PLAY);
    run(0);
}

static void run_plain(int16_t count)
{
    TEST_ASSERT_TRUE(bench_queue_run(LINE_MARK_START, count, 1));
    run(0);
}

// A smooth line moves the load by all of its way, and knows it.
static void check_smooth(uint16_t mark)
{
    int32_t before = load;

    run_smooth(mark);
    TEST_ASSERT_FALSE(bench.axis.play_unknown);
    TEST_ASSERT_EQUAL_INT32(mark == PLUS ? WAY : -WAY, load - before);
}

static void know_plus(void)
{
    run_smooth(PLUS);
    TEST_ASSERT_EQUAL_INT32(0, motor);
}

static void first_line_takes_up_all_and_says_so(void)
{
    run_smooth(PLUS);
    TEST_ASSERT_TRUE(bench.axis.play_unknown);
    TEST_ASSERT_EQUAL_INT32(WAY + PLAY, bench.steps);
    check_smooth(PLUS);
    TEST_ASSERT_EQUAL_INT32(WAY + PLAY + WAY, bench.steps);
}

static void each_reversal_takes_up_all(void)
{
    know_plus();
    check_smooth(MINUS);
    check_smooth(MINUS);
    check_smooth(PLUS);
}

// The line is stopped in its ramp, in its take-up, right at the end of it, and later.
static void stopped_anywhere(void)
{
    for (int32_t steps = 1; steps <= WAY + PLAY; steps += steps < 130 ? 3 : 50) {
        setUp();
        know_plus();
        queue_smooth(MINUS, PLAY);
        run(steps);
        check_smooth(MINUS);
        setUp();
        know_plus();
        queue_smooth(MINUS, PLAY);
        run(steps);
        check_smooth(PLUS);
    }
}

// What is cut off of a pulse train was never made, though the ledger has taken its entry.
static void stopped_inside_a_train(void)
{
    for (int32_t steps = 1; steps <= 290; steps += 17) {
        setUp();
        know_plus();
        TEST_ASSERT_TRUE(bench_queue_run(LINE_MARK_START, -300, 1));
        run(steps);
        check_smooth(PLUS);
    }
}

static void stopped_twice_in_the_play(void)
{
    know_plus();
    queue_smooth(MINUS, PLAY);
    run(13);
    queue_smooth(PLUS, PLAY);
    run(5);
    queue_smooth(PLUS, PLAY);
    run(2);
    check_smooth(MINUS);
}

static void moves_shorter_than_the_play(void)
{
    know_plus();
    run_plain(-10);
    check_smooth(PLUS);
    run_plain(-10);
    run_plain(4);
    run_plain(-25);
    check_smooth(MINUS);
    run_plain(39);
    check_smooth(PLUS);
}

static void plain_line_that_reverses(void)
{
    know_plus();
    TEST_ASSERT_EQUAL(BLOCK_TAKEN, bench_queue(LINE_MARK_START, 0));
    TEST_ASSERT_EQUAL(BLOCK_TAKEN, bench_queue(0, 0));
    static const int16_t counts[] = {-15, 0, 0, 3, 0, 0, -8, 0, 11, -2};
    for (size_t i = 0; i < sizeof counts / sizeof counts[0]; i++) {
        TEST_ASSERT_EQUAL(BLOCK_TAKEN, bench_queue(counts[i], 1));
    }
    TEST_ASSERT_EQUAL(BLOCK_TAKEN, bench_queue(LINE_MARK_END, 0));
    run(0);
    check_smooth(PLUS);
}

// A disarmed line has decoded a reversal that was never made.
static void disarmed(void)
{
    know_plus();
    queue_smooth(MINUS, PLAY);
    TEST_ASSERT_TRUE(axis_arm(&bench.axis, &bench.period));
    decode_axis(&bench.axis, &bench.period, 64);
    axis_stop(&bench.axis);
    axis_discard(&bench.axis, bench.engine.tail);
    check_smooth(PLUS);
}

// After a reset only a move of the play's length tells, of whatever line.
static void unknown_until_a_long_move(void)
{
    run_plain(PLAY - 1);
    run_smooth(PLUS);
    TEST_ASSERT_TRUE(bench.axis.play_unknown);
    setUp();
    run_plain(PLAY);
    check_smooth(PLUS);
    setUp();
    run_plain(-PLAY);
    check_smooth(PLUS);
    setUp();
    run_plain(-PLAY + 1);
    run_plain(PLAY - 1);
    run_smooth(MINUS);
    TEST_ASSERT_TRUE(bench.axis.play_unknown);
}

// A line that does not know its play and is stopped leaves it unknown.
static void unknown_stays_unknown(void)
{
    queue_smooth(PLUS, PLAY);
    run(PLAY - 1);
    run_smooth(PLUS);
    TEST_ASSERT_TRUE(bench.axis.play_unknown);
    setUp();
    queue_smooth(PLUS, PLAY);
    run(PLAY);
    check_smooth(PLUS);
}

static void another_play_is_unknown(void)
{
    know_plus();
    queue_smooth(PLUS, PLAY - 1);
    run(0);
    TEST_ASSERT_TRUE(bench.axis.play_unknown);
    queue_smooth(PLUS, PLAY - 1);
    run(0);
    TEST_ASSERT_FALSE(bench.axis.play_unknown);
}

// Long ways of one direction: 16 bits of a position come round.
static void long_ways(void)
{
    know_plus();
    for (uint8_t i = 0; i < 5; i++) {
        TEST_ASSERT_TRUE(bench_queue_run(LINE_MARK_START, 1600, 10));
        run(0);
    }
    check_smooth(PLUS);
    run_plain(-10);
    for (uint8_t i = 0; i < 5; i++) {
        TEST_ASSERT_TRUE(bench_queue_run(LINE_MARK_START, -1600, 10));
        run(0);
    }
    check_smooth(MINUS);
}

static void zero_moves_the_place_along(void)
{
    know_plus();
    ledger_zero(&bench.axis.ledger, 12345);
    check_smooth(PLUS);
    run_plain(-10);
    ledger_zero(&bench.axis.ledger, -70000);
    check_smooth(MINUS);
}

// Behind a line with backlash, which will have taken up all of it, a line follows without a pause.
static void chained(void)
{
    know_plus();
    int32_t before = bench.steps;
    queue_smooth(MINUS, PLAY);
    queue_smooth(MINUS, PLAY);
    queue_smooth(PLUS, PLAY);
    run(0);
    TEST_ASSERT_EQUAL_INT32(-WAY - PLAY - WAY + WAY + PLAY, bench.steps - before);
    TEST_ASSERT_FALSE(bench.axis.play_unknown);
}

// Behind another line nobody can tell in time.
static void chained_behind_a_plain_line(void)
{
    know_plus();
    int32_t before = bench.steps;
    TEST_ASSERT_TRUE(bench_queue_run(LINE_MARK_START, 50, 1));
    queue_smooth(PLUS, PLAY);
    run(0);
    TEST_ASSERT_TRUE(bench.axis.play_unknown);
    TEST_ASSERT_EQUAL_INT32(50 + PLAY + WAY, bench.steps - before);
    check_smooth(MINUS);
}

int main(void)
{
    UNITY_BEGIN();

    RUN_TEST(first_line_takes_up_all_and_says_so);
    RUN_TEST(each_reversal_takes_up_all);
    RUN_TEST(stopped_anywhere);
    RUN_TEST(stopped_inside_a_train);
    RUN_TEST(stopped_twice_in_the_play);
    RUN_TEST(moves_shorter_than_the_play);
    RUN_TEST(plain_line_that_reverses);
    RUN_TEST(disarmed);
    RUN_TEST(unknown_until_a_long_move);
    RUN_TEST(unknown_stays_unknown);
    RUN_TEST(another_play_is_unknown);
    RUN_TEST(long_ways);
    RUN_TEST(zero_moves_the_place_along);
    RUN_TEST(chained);
    RUN_TEST(chained_behind_a_plain_line);
    return UNITY_END();
}
