// SPDX-License-Identifier: MIT
// The check of time: an axis whose interrupt missed a period is found, any axis, at rest and in
// lines of every speed; nothing else is.
#include <stdbool.h>
#include <stdint.h>

#include "app/axes/axes.h"
#include "app/watch/time_check.h"
#include "fakes/board.h"
#include "fakes/board_bench.h"
#include "hal/clock.h"
#include "hal/step_timer.h"
#include "ring/step_codes.h"
#include "unity.h"

#define CHECK_EVERY_UNITS 1024u

void setUp(void)
{
    bench_power_on();
    bench_settings()->bus_timeout_ms = 0;
    limits_apply_settings();
}

void tearDown(void)
{
}

#if CONFIG_AXES > 1

static void no_fault(void)
{
    TEST_ASSERT_EQUAL(FAULT_none, faults_record()->code);
}

static void all_axes_pass(void)
{
    for (uint8_t axis = 0; axis < CONFIG_AXES; axis++) {
        TEST_ASSERT_FALSE(time_check_lags(axis));
        TEST_ASSERT_TRUE(time_check_passes(axis));
    }
}

static void an_axis_at_rest_passes_whenever_it_is_asked(void)
{
    for (uint16_t i = 0; i < 2000; i++) {
        fake_pass(37u + i % 101u);
        all_axes_pass();
    }
    no_fault();
}

// The start of all timers may lie anywhere between two counts of the clock. The accounts begin anew
// with the timers.
static void start_is_found(uint16_t phase)
{
    fake_power_on();
    for (uint8_t axis = 0; axis < CONFIG_AXES; axis++) {
        ledger_restart(&axes_get(axis)->ledger, STEP_IDLE_TICKS);
    }
    fake_pass(10000u + phase);
    time_check_start();
    for (uint8_t i = 0; i < 40; i++) {
        fake_pass(997u);
        TEST_ASSERT_FALSE(time_check_lags(0));
        TEST_ASSERT_FALSE(time_check_lags(BENCH_LAST));
    }
}

static void any_start_of_the_timers_is_found(void)
{
    for (uint16_t phase = 0; phase < 2u * CLOCK_UNIT_TICKS; phase++) {
        start_is_found(phase);
    }
}

static void run_line(uint8_t axis, int16_t count)
{
    bench_plain_line(axis, count, 400);
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(BENCH_MASK_OF(axis), COMMAND_ARM));
    TEST_ASSERT_TRUE(bench_until(axis, AXIS_RUNNING));
    bench_rounds(100);
    no_fault();
}

static void each_axis_that_missed_a_period_is_named(void)
{
    for (uint8_t axis = 0; axis < CONFIG_AXES; axis++) {
        setUp();
        run_line(axis, 16);
        fake_missed_period(axis);
        for (uint8_t other = 0; other < CONFIG_AXES; other++) {
            TEST_ASSERT_EQUAL(other == axis, time_check_lags(other));
            TEST_ASSERT_EQUAL(other != axis, time_check_passes(other));
        }
        TEST_ASSERT_EQUAL(FAULT_underrun, faults_record()->code);
        TEST_ASSERT_EQUAL_UINT8(axis, faults_record()->axis);
        // Named once: the time base is lost for all until everything begins anew.
        TEST_ASSERT_TRUE(time_check_passes(axis));
    }
}

// One axis after the other, each within its turn.
static void until_a_fault(uint32_t most_units)
{
    uint32_t began_units = clock_now_units();

    while (faults_record()->code == FAULT_none) {
        TEST_ASSERT_TRUE(clock_now_units() - began_units < most_units);
        bench_rounds(1);
    }
}

static void the_round_asks_each_axis_in_time(void)
{
    for (uint8_t axis = 0; axis < CONFIG_AXES; axis++) {
        setUp();
        run_line(axis, 16);
        fake_missed_period(axis);
        until_a_fault((CONFIG_AXES + 1u) * CHECK_EVERY_UNITS);
        TEST_ASSERT_EQUAL(FAULT_underrun, faults_record()->code);
        TEST_ASSERT_EQUAL_UINT8(axis, faults_record()->axis);
    }
}

// Not every round asks: a check costs time.
static void a_check_is_not_made_in_every_round(void)
{
    uint16_t asked = 0;

    for (uint16_t i = 0; i < 100; i++) {
        setUp();
        run_line(BENCH_LAST, 16);
        bench_rounds(i);
        fake_missed_period(BENCH_LAST);
        time_check_poll();
        asked = (uint16_t)(asked + (faults_record()->code != FAULT_none));
    }
    TEST_ASSERT_TRUE(asked < 20);
}

static void passes_while_it_runs(int16_t count)
{
    setUp();
    run_line(BENCH_LAST, count);
    for (uint16_t k = 0; k < 300; k++) {
        fake_pass(53u + k % 89u);
        TEST_ASSERT_FALSE(time_check_lags(BENCH_LAST));
        bench_rounds(k % 8u == 0 ? 1 : 0);
    }
    no_fault();
}

static void a_running_axis_passes_at_every_speed(void)
{
    static const int16_t counts[] = {1, 7, 16, 40, 100};

    for (uint8_t i = 0; i < 5; i++) {
        passes_while_it_runs(counts[i]);
    }
}

static void a_running_axis_that_missed_a_period_is_found(void)
{
    static const int16_t counts[] = {1, 7, 16, 40, 100};

    for (uint8_t i = 0; i < 5; i++) {
        setUp();
        run_line(BENCH_LAST, counts[i]);
        fake_missed_period(BENCH_LAST);
        TEST_ASSERT_TRUE(time_check_lags(BENCH_LAST));
        TEST_ASSERT_FALSE(time_check_lags(0));
    }
}

#endif

int main(void)
{
    UNITY_BEGIN();
#if CONFIG_AXES > 1
    RUN_TEST(an_axis_at_rest_passes_whenever_it_is_asked);
    RUN_TEST(any_start_of_the_timers_is_found);
    RUN_TEST(each_axis_that_missed_a_period_is_named);
    RUN_TEST(the_round_asks_each_axis_in_time);
    RUN_TEST(a_check_is_not_made_in_every_round);
    RUN_TEST(a_running_axis_passes_at_every_speed);
    RUN_TEST(a_running_axis_that_missed_a_period_is_found);
#endif
    return UNITY_END();
}
