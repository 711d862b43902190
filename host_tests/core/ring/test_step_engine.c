// SPDX-License-Identifier: MIT
// The step engine on hand-written ring entries.
#include <stdbool.h>
#include <stdint.h>

#include "ring/step_engine.h"
#include "unity.h"

static struct step_ring ring;
static struct step_engine engine;
static uint8_t head;

void setUp(void)
{
    step_engine_reset(&engine, &ring);
    head = 0;
}

void tearDown(void)
{
}

static void put(uint8_t high, uint8_t low)
{
    ring.high[(uint8_t)(head + 1u)] = STEP_HIGH_EMPTY;
    ring.low[head] = low;
    ring.high[head] = high;
    head++;
}

static void put_period(uint16_t top_ticks)
{
    put((uint8_t)(top_ticks >> 8), (uint8_t)top_ticks);
}

static void put_command(enum step_command command)
{
    put(STEP_HIGH_COMMAND, (uint8_t)command);
}

static void check_load(uint16_t top_ticks, bool pulse, bool reverses)
{
    struct step_load load = step_engine_next(&engine, &ring);

    TEST_ASSERT_EQUAL_UINT16(top_ticks, load.top_ticks);
    TEST_ASSERT_EQUAL(pulse, load.pulse);
    TEST_ASSERT_EQUAL(reverses, load.reverses);
}

static void check_idle(void)
{
    check_load(STEP_IDLE_TICKS - 1u, false, false);
}

static void idles_and_counts(void)
{
    for (uint16_t i = 1; i <= 300; i++) {
        check_idle();
        TEST_ASSERT_EQUAL_UINT16(i, engine.idle_count);
    }
    TEST_ASSERT_EQUAL_UINT8(0, engine.tail);
    TEST_ASSERT_EQUAL(STEP_ENGINE_IDLE, engine.state);
}

static void idle_count_wraps(void)
{
    engine.idle_count = 0xFFFF;
    check_idle();
    TEST_ASSERT_EQUAL_UINT16(0, engine.idle_count);
}

static void shortest_and_longest_period(void)
{
    put_period(0);
    put_period(STEP_PERIOD_MAX_TICKS - 1u);
    check_load(0, false, false);
    check_load(STEP_PERIOD_MAX_TICKS - 1u, false, false);
    TEST_ASSERT_EQUAL_UINT16(0, engine.idle_count);
    check_idle();
}

static void pulse_and_quiet_last(void)
{
    put_command(STEP_COMMAND_PULSE);
    put_period(999);
    put_period(998);
    put_command(STEP_COMMAND_QUIET);
    put_period(997);
    check_load(999, true, false);
    check_load(998, true, false);
    check_load(997, false, false);
}

static void direction_with_the_next_period(void)
{
    put_command(STEP_COMMAND_NEGATIVE);
    put_command(STEP_COMMAND_PULSE);
    put_period(500);
    put_period(501);
    put_command(STEP_COMMAND_POSITIVE);
    put_period(502);
    check_load(500, true, true);
    TEST_ASSERT_TRUE(engine.negative);
    check_load(501, true, false);
    check_load(502, true, true);
    TEST_ASSERT_FALSE(engine.negative);
}

static void end_gives_one_idle_period(void)
{
    put_command(STEP_COMMAND_BEGIN);
    put_command(STEP_COMMAND_PULSE);
    put_period(700);
    put_command(STEP_COMMAND_END);
    put_period(701);
    check_load(700, true, false);
    TEST_ASSERT_EQUAL(STEP_ENGINE_IN_LINE, engine.state);
    check_idle();
    TEST_ASSERT_EQUAL(STEP_ENGINE_IDLE, engine.state);
    TEST_ASSERT_EQUAL_UINT16(1, engine.idle_count);
    check_load(701, false, false);
}

static void empty_in_a_line_halts(void)
{
    put_command(STEP_COMMAND_BEGIN);
    put_command(STEP_COMMAND_PULSE);
    put_period(700);
    check_load(700, true, false);
    check_idle();
    TEST_ASSERT_EQUAL(STEP_ENGINE_HALTED, engine.state);
    check_idle();
    TEST_ASSERT_EQUAL(STEP_ENGINE_HALTED, engine.state);
}

// The ring may run empty while the writer is adding an entry.
static void halted_leaves_later_entries_alone(void)
{
    put_command(STEP_COMMAND_BEGIN);
    put_command(STEP_COMMAND_PULSE);
    put_period(700);
    check_load(700, true, false);
    check_idle();
    uint8_t tail = engine.tail;

    put_command(STEP_COMMAND_PULSE);
    put_period(800);
    put_command(STEP_COMMAND_BEGIN);
    check_idle();
    check_idle();
    TEST_ASSERT_EQUAL_UINT8(tail, engine.tail);
    TEST_ASSERT_EQUAL(STEP_ENGINE_HALTED, engine.state);
}

// A reversal is not lost when the ring is empty behind it.
static void direction_before_an_idle_period(void)
{
    put_command(STEP_COMMAND_NEGATIVE);
    check_load(STEP_IDLE_TICKS - 1u, false, true);
    put_command(STEP_COMMAND_POSITIVE);
    put_command(STEP_COMMAND_END);
    check_load(STEP_IDLE_TICKS - 1u, false, true);
}

static void tail_wraps(void)
{
    for (uint16_t i = 0; i < 600; i++) {
        put_period(i);
        check_load(i, false, false);
        TEST_ASSERT_EQUAL_UINT8((uint8_t)(i + 1u), engine.tail);
    }
}

static void check_settled(bool settles, uint8_t slot)
{
    uint8_t found = 0xEE;

    TEST_ASSERT_EQUAL(settles, step_engine_settle(&engine, &ring, &found));
    TEST_ASSERT_EQUAL_UINT8(settles ? slot : 0xEE, found);
}

// A halted engine takes no entry, no matter how often it is asked.
static void check_halts_from(enum step_engine_state state, enum step_engine_state then)
{
    uint8_t tail = engine.tail;

    engine.state = (uint8_t)state;
    for (uint8_t times = 0; times < 3; times++) {
        step_engine_halt(&engine);
        TEST_ASSERT_EQUAL(then, engine.state);
        TEST_ASSERT_TRUE(engine.stop);
    }
    check_settled(then == STEP_ENGINE_HALTED, tail);
    for (uint8_t i = 0; i < 3; i++) {
        put_period(700);
        check_idle();
        TEST_ASSERT_EQUAL(STEP_ENGINE_HALTED, engine.state);
        step_engine_halt(&engine);
    }
    check_settled(true, tail);
    TEST_ASSERT_EQUAL(STEP_ENGINE_IDLE, engine.state);
    TEST_ASSERT_FALSE(engine.stop);
    TEST_ASSERT_EQUAL_HEX8(STEP_HIGH_EMPTY, ring.high[tail]);
}

static void halts_in_a_line(void)
{
    check_halts_from(STEP_ENGINE_IN_LINE, STEP_ENGINE_HALTING);
}

static void halts_out_of_a_line(void)
{
    check_halts_from(STEP_ENGINE_IDLE, STEP_ENGINE_HALTING);
}

static void halts_while_it_halts(void)
{
    check_halts_from(STEP_ENGINE_HALTING, STEP_ENGINE_HALTING);
}

static void stays_halted(void)
{
    engine.state = STEP_ENGINE_HALTED;
    step_engine_halt(&engine);
    TEST_ASSERT_EQUAL(STEP_ENGINE_HALTED, engine.state);
    check_settled(true, 0);
}

// The timer still holds a period that pulses.
static void settles_only_at_rest(void)
{
    put_command(STEP_COMMAND_BEGIN);
    put_command(STEP_COMMAND_PULSE);
    put_period(700);
    check_load(700, true, false);
    check_settled(false, 0);
    TEST_ASSERT_TRUE(engine.pulse);
    step_engine_halt(&engine);
    check_settled(false, 0);
    TEST_ASSERT_TRUE(engine.pulse);
    check_idle();
    check_settled(true, 3);
    TEST_ASSERT_FALSE(engine.pulse);
}

// A halt inside step_engine_next() leaves the entry alone that is being taken.
static void halted_while_it_takes(void)
{
    engine.left = 5;
    engine.state = STEP_ENGINE_IN_LINE;
    step_engine_halt_soon(&engine);
    TEST_ASSERT_TRUE(engine.stop);
    TEST_ASSERT_EQUAL_INT8(5, engine.left);
    TEST_ASSERT_EQUAL_INT8(0, engine.cut);
    TEST_ASSERT_EQUAL(STEP_ENGINE_IN_LINE, engine.state);
}

static void rest_of_a_train_is_cut_once(void)
{
    engine.left = -5;
    engine.state = STEP_ENGINE_IN_LINE;
    step_engine_halt(&engine);
    TEST_ASSERT_EQUAL_INT8(0, engine.left);
    TEST_ASSERT_EQUAL_INT8(-5, engine.cut);
    step_engine_halt(&engine);
    TEST_ASSERT_EQUAL_INT8(-5, engine.cut);
    TEST_ASSERT_EQUAL_UINT8(5, step_engine_sample(&engine).left);
}

static void an_empty_ring_in_a_line_stops(void)
{
    put_command(STEP_COMMAND_BEGIN);
    check_idle();
    TEST_ASSERT_TRUE(engine.stop);
}

static void a_reset_forgets_a_halt_that_was_to_come(void)
{
    step_engine_halt_soon(&engine);
    step_engine_reset(&engine, &ring);
    TEST_ASSERT_FALSE(engine.stop);
    put_command(STEP_COMMAND_PULSE);
    put_period(100);
    check_load(100, true, false);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(idles_and_counts);
    RUN_TEST(idle_count_wraps);
    RUN_TEST(shortest_and_longest_period);
    RUN_TEST(pulse_and_quiet_last);
    RUN_TEST(direction_with_the_next_period);
    RUN_TEST(end_gives_one_idle_period);
    RUN_TEST(empty_in_a_line_halts);
    RUN_TEST(halted_leaves_later_entries_alone);
    RUN_TEST(direction_before_an_idle_period);
    RUN_TEST(tail_wraps);
    RUN_TEST(halted_while_it_takes);
    RUN_TEST(rest_of_a_train_is_cut_once);
    RUN_TEST(halts_in_a_line);
    RUN_TEST(halts_out_of_a_line);
    RUN_TEST(halts_while_it_halts);
    RUN_TEST(stays_halted);
    RUN_TEST(settles_only_at_rest);
    RUN_TEST(an_empty_ring_in_a_line_stops);
    RUN_TEST(a_reset_forgets_a_halt_that_was_to_come);
    return UNITY_END();
}
