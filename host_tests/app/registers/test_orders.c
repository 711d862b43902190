// SPDX-License-Identifier: MIT
// Commands in unplanned sequences: twice, too late, side by side, on axes in every state.
#include <stdint.h>

#include "app/registers/report.h"
#include "app/round.h"
#include "app/settings/store.h"
#include "fakes/board.h"
#include "fakes/board_bench.h"
#include "hal/step_timer.h"
#include "nothing_moves.h"
#include "unity.h"
#include "wire/bytes.h"
#include "wire/register_map.h"
#include "wire/server.h"

#define SLOW_STEPS_PX 2 // a period that the timer holds lasts many rounds

void setUp(void)
{
    bench_power_on();
    bench_rounds(50);
}

void tearDown(void)
{
}

static void command(uint16_t mask, enum command what)
{
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(mask, what));
}

static void refused(uint16_t mask, enum command what)
{
    TEST_ASSERT_EQUAL(MODBUS_DEVICE_FAILURE, bench_command(mask, what));
}

static void until_steps(uint8_t axis, int32_t steps)
{
    for (uint16_t i = 0; i < 20000 && fake_axes[axis].steps < steps; i++) {
        bench_rounds(1);
    }
    TEST_ASSERT_GREATER_OR_EQUAL_INT32(steps, fake_axes[axis].steps);
}

static void run_line(uint8_t axis, int16_t steps_px)
{
    bench_plain_line(axis, steps_px, 200);
    command((uint16_t)(1u << axis), COMMAND_ARM);
    until_steps(axis, 3);
}

static void check_usable(uint8_t axis)
{
    int32_t steps = fake_axes[axis].steps;

    bench_plain_line(axis, 10, 3);
    command((uint16_t)(1u << axis), COMMAND_ARM);
    TEST_ASSERT_TRUE(bench_until(axis, AXIS_DONE));
    TEST_ASSERT_EQUAL_INT32(steps + 30, fake_axes[axis].steps);
    check_nothing_moves();
    TEST_ASSERT_EQUAL(FAULT_none, faults_record()->code);
}

// The second command comes while the timer still holds a pulsing period.
static void check_twice(enum command again)
{
    run_line(1, SLOW_STEPS_PX);
    command(2, COMMAND_STOP);
    TEST_ASSERT_TRUE(step_engine_going(step_timer_state(1)));
    command(2, again);
    TEST_ASSERT_EQUAL(AXIS_STOPPING, axes_get(1)->life.state);
    TEST_ASSERT_EQUAL(MODBUS_BUSY, bench_entry(1, SLOW_STEPS_PX, 1));
    TEST_ASSERT_EQUAL_HEX16(REPORT_CLOCK | REPORT_STOPPING << 1u,
                            bench_input(REG_INPUT_status));
    TEST_ASSERT_EQUAL(AXIS_EMPTY, bench_input(REG_AXIS_BASE + REG_AXIS_STRIDE));
    bench_rounds(300);
    TEST_ASSERT_EQUAL_HEX8(0, bench_axes_in(AXIS_STOPPING));
    TEST_ASSERT_EQUAL(STEP_ENGINE_PARKED, step_timer_state(1));
    check_nothing_moves();
    TEST_ASSERT_EQUAL(FAULT_none, faults_record()->code);
    check_usable(1);
}

static void stopped_twice(void)
{
    check_twice(COMMAND_STOP);
}

static void stopped_and_disarmed(void)
{
    check_twice(COMMAND_DISARM);
}

static void stopped_and_discarded(void)
{
    check_twice(COMMAND_DISCARD);
}

static void driver_of_a_stopping_axis_stays_on(void)
{
    run_line(1, SLOW_STEPS_PX);
    command(2, COMMAND_STOP);
    refused(2, COMMAND_DISABLE);
    TEST_ASSERT_TRUE(fake_axes[1].enabled);
    bench_rounds(300);
    command(2, COMMAND_DISABLE);
    TEST_ASSERT_FALSE(fake_axes[1].enabled);
}

static void released_line_is_stopped_before_it_begins(void)
{
    bench_plain_line(1, 10, 3);
    command(2, COMMAND_ARM);
    TEST_ASSERT_TRUE(bench_until(1, AXIS_RUNNING));
    command(2, COMMAND_STOP);
    TEST_ASSERT_EQUAL(AXIS_EMPTY, axes_get(1)->life.state);
    check_nothing_moves();
    TEST_ASSERT_EQUAL_INT32(0, fake_axes[1].steps);
    check_usable(1);
}

// Stray steps are noticed and ended.
static void stray_steps_are_a_fault(void)
{
    bench_rounds(20);
    fake_stray_steps(BENCH_THIRD);
    bench_rounds(40);
    TEST_ASSERT_EQUAL(FAULT_stray_steps, faults_record()->code);
    TEST_ASSERT_EQUAL_UINT8(BENCH_THIRD, faults_record()->axis);
    TEST_ASSERT_TRUE(faults_time_lost());
    int32_t steps = fake_axes[BENCH_THIRD].steps;
    bench_rounds(200);
    TEST_ASSERT_EQUAL_INT32(steps, fake_axes[BENCH_THIRD].steps);
    command(0, COMMAND_CLEAR_FAULT);
    bench_plain_line(BENCH_THIRD, 10, 3);
    command(BENCH_MASK_OF(BENCH_THIRD), COMMAND_ARM);
    TEST_ASSERT_TRUE(bench_until(BENCH_THIRD, AXIS_DONE));
    TEST_ASSERT_EQUAL_INT32(steps + 30, fake_axes[BENCH_THIRD].steps);
}

static void emergency_stop_ends_stray_steps(void)
{
    fake_stray_steps(BENCH_THIRD);
    fake_estop(false);
    int32_t steps = fake_axes[BENCH_THIRD].steps;
    bench_rounds(200);
    TEST_ASSERT_INT32_WITHIN(2, steps, fake_axes[BENCH_THIRD].steps);
    steps = fake_axes[BENCH_THIRD].steps;
    bench_rounds(200);
    TEST_ASSERT_EQUAL_INT32(steps, fake_axes[BENCH_THIRD].steps);
}

// The emergency stop halts every engine; a queued line survives it.
static void loaded_line_survives_an_emergency_stop(void)
{
    bench_plain_line(BENCH_LAST, 10, 3);
    fake_estop(false);
    bench_rounds(20);
    TEST_ASSERT_EQUAL(FAULT_estop, faults_record()->code);
    TEST_ASSERT_EQUAL(AXIS_LOADED, axes_get(BENCH_LAST)->life.state);
    TEST_ASSERT_FALSE(step_timer_unpark(BENCH_LAST));
    fake_estop(true);
    command(0, COMMAND_CLEAR_FAULT);
    bench_rounds(3);
    command(BENCH_MASK_OF(BENCH_LAST), COMMAND_ARM);
    TEST_ASSERT_TRUE(bench_until(BENCH_LAST, AXIS_DONE));
    TEST_ASSERT_EQUAL_INT32(30, fake_axes[BENCH_LAST].steps);
}

static void permit_stays_off_after_an_emergency_stop(void)
{
    fake_estop(false);
    // The main loop has not noticed the emergency stop yet.
    refused(0, COMMAND_PERMIT_ON);
    TEST_ASSERT_FALSE(fake_permit);
    TEST_ASSERT_FALSE(permit_is_on());
}

// A refused block changes nothing for an armed axis: a better one may follow.
static void refused_block_leaves_an_armed_axis(void)
{
    uint8_t words[8];

    bench_plain_line(0, 10, 3);
    (void)bench_long_start(1);
    command(3, COMMAND_ARM);
    uint16_t next = axes_get(1)->next_block;
    put_word(&words[0], next);
    put_word(&words[2], 1);
    put_word(&words[4], LINE_MARK_START); // inside a line
    put_word(&words[6], 0);
    TEST_ASSERT_EQUAL(MODBUS_ILLEGAL_VALUE, data_write(REG_QUEUE_WINDOW, 4, words));
    TEST_ASSERT_EQUAL(AXIS_ARMED, axes_get(1)->life.state);
    TEST_ASSERT_EQUAL_UINT16(next, axes_get(1)->next_block);
    TEST_ASSERT_TRUE(bench_until(1, AXIS_RUNNING));
    TEST_ASSERT_EQUAL(AXIS_RUNNING, axes_get(0)->life.state);
    TEST_ASSERT_EQUAL_UINT32(axes_get(0)->zero_ticks, axes_get(1)->zero_ticks);
}

// A line that is queued while the line before it ends can be armed.
static void second_line_longer_than_the_queue(void)
{
    run_line(0, 10);
    uint16_t i = 0;
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_entry(0, LINE_MARK_START | LINE_START_WAIT, 0));
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_entry(0, 0, 0));
    while (bench_entry(0, (int16_t)(5 + i % 2u), 1) == MODBUS_OK) {
        i++;
    }
    TEST_ASSERT_EQUAL(AXIS_RUNNING, axes_get(0)->life.state);
    TEST_ASSERT_TRUE(bench_until(0, AXIS_LOADED));
    command(1, COMMAND_ARM);
}

static void check_keyed(bool taken, enum command what, uint16_t key)
{
    TEST_ASSERT_EQUAL(taken, bench_give(0, what, key));
}

static void storing_wants_its_key_and_a_machine_without_lines(void)
{
    check_keyed(false, COMMAND_STORE, COMMANDS_KEY + 1u);
    check_keyed(false, COMMAND_DEFAULTS, COMMANDS_KEY + 1u);
    bench_plain_line(0, 10, 2);
    check_keyed(false, COMMAND_STORE, COMMANDS_KEY);
    TEST_ASSERT_FALSE(store_busy());
    command(1, COMMAND_DISCARD);
    check_keyed(true, COMMAND_DEFAULTS, COMMANDS_KEY);
    check_keyed(true, COMMAND_STORE, COMMANDS_KEY);
    check_keyed(false, COMMAND_STORE, COMMANDS_KEY); // one at a time
    bench_rounds(200);
    TEST_ASSERT_FALSE(store_busy());
}

static void disarming_forgets_the_token(void)
{
    bench_plain_line(0, 10, 200);
    TEST_ASSERT_TRUE(bench_give(1, COMMAND_ARM, 5));
    command(1, COMMAND_DISARM);
    TEST_ASSERT_EQUAL_UINT16(0, token_now());
    run_line(1, 10);
    TEST_ASSERT_FALSE(bench_give(0, COMMAND_GO, 6));
    TEST_ASSERT_EQUAL(FAULT_none, faults_record()->code);
    TEST_ASSERT_EQUAL(AXIS_RUNNING, axes_get(1)->life.state);
}

static void token_stays_for_the_other_armed_axis(void)
{
    bench_plain_line(0, 10, 200);
    bench_plain_line(1, 10, 200);
    TEST_ASSERT_TRUE(bench_give(3, COMMAND_ARM, 5));
    command(1, COMMAND_STOP);
    TEST_ASSERT_EQUAL_UINT16(5, token_now());
    command(2, COMMAND_STOP);
    TEST_ASSERT_EQUAL_UINT16(0, token_now());
    bench_rounds(20);
    bench_plain_line(0, 10, 200);
    TEST_ASSERT_TRUE(bench_give(1, COMMAND_ARM, 5));
    command(2, COMMAND_STOP);
    TEST_ASSERT_EQUAL_UINT16(5, token_now());
}

// A pixel clock with another frequency than the setting stops axes that wait for it or run by it.
static void check_clock_off(uint32_t num, uint32_t den)
{
    fake_pixel_clock(fake_now_ticks() + 5000u, num, den);
    for (uint16_t i = 0; i < 400 && faults_record()->code == FAULT_none; i++) {
        bench_rounds(1);
    }
    TEST_ASSERT_EQUAL(FAULT_pixel_clock_off, faults_record()->code);
    TEST_ASSERT_EQUAL_UINT8(BENCH_THIRD, faults_record()->axis);
    TEST_ASSERT_EQUAL(AXIS_FAULT, axes_get(BENCH_THIRD)->life.state);
    check_nothing_moves();
}

static void clock_twice_as_fast_while_running(void)
{
    run_line(BENCH_THIRD, 10);
    check_clock_off(2u * BENCH_PIXEL_HZ, 1);
    // In step with the clock before, the first interval would be half a period, 31.
    TEST_ASSERT_UINT16_WITHIN(31, 31, faults_record()->argument);
}

static void clock_ten_percent_fast_while_running(void)
{
    run_line(BENCH_THIRD, 10);
    check_clock_off(11u * BENCH_PIXEL_HZ, 10);
}

static void clock_ten_percent_slow_while_armed(void)
{
    bench_plain_line(BENCH_THIRD, 10, 3);
    fake_pixel_clock(fake_now_ticks() + 5000u, 9u * BENCH_PIXEL_HZ, 10);
    bench_rounds(50);
    command(BENCH_MASK_OF(BENCH_THIRD), COMMAND_ARM);
    check_clock_off(9u * BENCH_PIXEL_HZ, 10);
    TEST_ASSERT_EQUAL_INT32(0, fake_axes[BENCH_THIRD].steps);
}

static void clock_five_percent_fast_is_followed(void)
{
    fake_pixel_clock(fake_now_ticks() + 5000u, 21u * BENCH_PIXEL_HZ, 20);
    bench_rounds(50);
    bench_plain_line(BENCH_THIRD, 10, 3);
    command(BENCH_MASK_OF(BENCH_THIRD), COMMAND_ARM);
    TEST_ASSERT_TRUE(bench_until(BENCH_THIRD, AXIS_DONE));
    TEST_ASSERT_EQUAL(FAULT_none, faults_record()->code);
}

// The first edge behind a rest stands alone, however far it is from the one before.
static void clock_that_has_rested_may_start_a_line(void)
{
    bench_settings()->bus_timeout_ms = 0;
    check_usable(1);
    bench_clock_off();
    for (uint16_t i = 0; i < 3500; i++) {
        fake_pass(200000uL);
        round_poll();
    }
    TEST_ASSERT_FALSE(reference_present());
    fake_pixel_clock(fake_now_ticks() + 5000u, BENCH_PIXEL_HZ, 1);
    check_usable(1);
}

static void zero_pixels_at_a_fast_clock_begin(void)
{
    uint8_t words[8] = {0};

    put_word(&words[2 * 0], 0);
    put_word(&words[2 * 1], 5000); // Hz
    put_word(&words[2 * 2], 0);
    put_word(&words[2 * 3], 1);
    TEST_ASSERT_EQUAL(MODBUS_OK, data_write(REG_HOLDING_pixel_hz_num, 4, words));
    bench_clock_off();
    (void)bench_entry(0, LINE_MARK_START, 0);
    (void)bench_entry(0, 0, 0);
    (void)bench_entry(0, 0, 200);
    (void)bench_entry(0, 1, 3);
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_entry(0, LINE_MARK_END, 0));
    command(1, COMMAND_ARM);
    TEST_ASSERT_TRUE(bench_until(0, AXIS_RUNNING));
    for (uint16_t i = 0; i < 2000 && axes_get(0)->life.state == AXIS_RUNNING; i++) {
        fake_pass(1000);
        round_poll();
    }
    TEST_ASSERT_EQUAL(FAULT_none, faults_record()->code);
    TEST_ASSERT_EQUAL(AXIS_DONE, axes_get(0)->life.state);
    TEST_ASSERT_EQUAL_INT32(3, fake_axes[0].steps);
}

// Steps closer together than all axes may make them beside each other, and not too close for one.
static void axes_that_are_too_fast_together_are_not_armed(void)
{
    int16_t steps = (int16_t)(BENCH_PIXEL_TICKS / CONFIG_MIN_INTERVAL_TICKS + 10u);

    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        bench_plain_line(i, steps, 30);
    }
    refused(BENCH_ALL_AXES, COMMAND_ARM);
    TEST_ASSERT_EQUAL(LINE_too_fast_together, axes_get(0)->line_error);
    TEST_ASSERT_EQUAL_HEX8(0, bench_axes_in(AXIS_ARMED));
    TEST_ASSERT_EQUAL_HEX8(BENCH_ALL_AXES, bench_axes_in(AXIS_LOADED));
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        command(BENCH_MASK_OF(i), COMMAND_ARM);
        TEST_ASSERT_EQUAL(true, bench_until(i, AXIS_DONE));
        TEST_ASSERT_EQUAL_INT32(30 * (int32_t)steps, fake_axes[i].steps);
    }
}

#if FEATURE_TOKENS && CONFIG_AXES > 1
// The last axis is not armed, by whatever token.
static void nobody_joins_by(uint16_t token)
{
    TEST_ASSERT_FALSE(bench_give(BENCH_MASK_OF(BENCH_LAST), COMMAND_ARM, token));
}

// Lets axis 0 wait for an edge that `go` has named; returns the edge.
static uint16_t one_axis_waits_for_its_edge(void)
{
    bench_plain_line(0, 10, 3);
    bench_plain_line(BENCH_LAST, 10, 3);
    TEST_ASSERT_TRUE(bench_give(1, COMMAND_ARM, 5));
    bench_rounds(50);
    TEST_ASSERT_TRUE(bench_give(1, COMMAND_MARK, 0));
    bench_rounds(1);
    const uint16_t edge = bench_edge_ahead(40);
    const struct order go = {1, COMMAND_GO, 5, edge};
    TEST_ASSERT_TRUE(commands_give(&go));
    return edge;
}
#endif

// What `go` has named is a number of an edge, and no token any more: nobody joins by it, nor by the
// token, nor without one.
static void nobody_joins_an_edge_that_is_named(void)
{
#if FEATURE_TOKENS && CONFIG_AXES > 1
    const uint16_t edge = one_axis_waits_for_its_edge();
    nobody_joins_by(edge);
    nobody_joins_by(5);
    nobody_joins_by(0);
    TEST_ASSERT_TRUE(bench_until(0, AXIS_DONE));
    TEST_ASSERT_EQUAL(AXIS_LOADED, axes_get(BENCH_LAST)->life.state);
    TEST_ASSERT_EQUAL(FAULT_none, faults_record()->code);
#endif
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(stopped_twice);
    RUN_TEST(stopped_and_disarmed);
    RUN_TEST(stopped_and_discarded);
    RUN_TEST(driver_of_a_stopping_axis_stays_on);
    RUN_TEST(released_line_is_stopped_before_it_begins);
    RUN_TEST(stray_steps_are_a_fault);
    RUN_TEST(emergency_stop_ends_stray_steps);
    RUN_TEST(loaded_line_survives_an_emergency_stop);
    RUN_TEST(permit_stays_off_after_an_emergency_stop);
    RUN_TEST(refused_block_leaves_an_armed_axis);
    RUN_TEST(second_line_longer_than_the_queue);
    RUN_TEST(storing_wants_its_key_and_a_machine_without_lines);
    RUN_TEST(disarming_forgets_the_token);
    RUN_TEST(token_stays_for_the_other_armed_axis);
    RUN_TEST(nobody_joins_an_edge_that_is_named);
    RUN_TEST(clock_twice_as_fast_while_running);
    RUN_TEST(clock_ten_percent_fast_while_running);
    RUN_TEST(clock_ten_percent_slow_while_armed);
    RUN_TEST(clock_five_percent_fast_is_followed);
    RUN_TEST(clock_that_has_rested_may_start_a_line);
    RUN_TEST(zero_pixels_at_a_fast_clock_begin);
    RUN_TEST(axes_that_are_too_fast_together_are_not_armed);
    return UNITY_END();
}
