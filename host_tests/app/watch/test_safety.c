// SPDX-License-Identifier: MIT
// Causes that stop the machine or keep it from starting: emergency stop, silent bus, token,
// watchdog, driver timing, permit output.
#include <stdbool.h>
#include <stdint.h>

#include "app/board.h"
#include "app/bus/traffic.h"
#include "app/round.h"
#include "app/watch/drivers.h"
#include "app/watch/safety.h"
#include "app/watch/time_check.h"
#include "fakes/board.h"
#include "fakes/board_bench.h"
#include "hal/clock.h"
#include "hal/estop.h"
#include "unity.h"
#include "wire/register_map.h"

#define TOKEN 0xBEEF

void setUp(void)
{
    bench_power_on();
}

void tearDown(void)
{
}

static enum modbus_exception order(uint8_t mask, enum command command, uint16_t argument)
{
    uint16_t edge = command == COMMAND_GO ? bench_edge_ahead(BENCH_GO_EDGES) : 0;
    uint8_t words[8] = {0,
                        mask,
                        0,
                        (uint8_t)command,
                        (uint8_t)(argument >> 8),
                        (uint8_t)argument,
                        (uint8_t)(edge >> 8),
                        (uint8_t)edge};

    return data_write(REG_HOLDING_axis_mask, 4, words);
}

static uint16_t fault(void)
{
    return bench_input(REG_INPUT_fault_code);
}

// So many pixels last as many milliseconds at 16 MHz, fewer on a faster board.
#define PIXELS_MS(pixels)                                                                \
    ((uint16_t)((pixels) * (uint32_t)BENCH_PIXEL_TICKS / BENCH_TICKS_PER_MS))

static void pass_ms(uint16_t ms)
{
    for (uint32_t i = 0; i < ms * BENCH_TICKS_PER_MS / BENCH_ROUND_TICKS + 1u; i++) {
        bench_rounds(1);
    }
}

static void run_a_line(void)
{
    bench_plain_line(0, 10, 500);
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(1, COMMAND_ARM));
    TEST_ASSERT_TRUE(bench_until(0, AXIS_RUNNING));
    bench_rounds(500);
}

static void estop_halts_latches_and_wants_a_clear(void)
{
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(0, COMMAND_PERMIT_ON));
    run_a_line();
    fake_estop(false);
    int32_t steps = fake_axes[0].steps;
    TEST_ASSERT_FALSE(fake_permit);
    bench_rounds(100);
    TEST_ASSERT_INT32_WITHIN(1, steps, fake_axes[0].steps);
    TEST_ASSERT_EQUAL_UINT16(FAULT_estop, fault());
    TEST_ASSERT_EQUAL_UINT16(1u << FAULT_estop, bench_input(REG_INPUT_fault_mask));
    TEST_ASSERT_EQUAL_INT32(fake_axes[0].steps, ledger_position(&axes_get(0)->ledger));
    TEST_ASSERT_EQUAL(MODBUS_DEVICE_FAILURE, bench_command(0, COMMAND_CLEAR_FAULT));
    fake_estop(true);
    bench_rounds(10);
    TEST_ASSERT_EQUAL_UINT16(FAULT_estop, fault());
    TEST_ASSERT_EQUAL(MODBUS_DEVICE_FAILURE, bench_command(0, COMMAND_PERMIT_ON));
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(0, COMMAND_CLEAR_FAULT));
    bench_rounds(10);
    TEST_ASSERT_EQUAL_UINT16(FAULT_none, fault());
    run_a_line();
    TEST_ASSERT_EQUAL_UINT16(FAULT_none, fault());
}

// Normally closed: the pin is low while all is well.
// The account of the axis lags by up to two pixels, by the round in which the stop comes.
static void estop_names_the_pixel_that_was_reached(void)
{
    for (uint16_t rounds = 330; rounds < 340; rounds++) {
        bench_power_on();
        bench_plain_line(0, 30, 500);
        bench_plain_line(1, 60, 500);
        TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(3, COMMAND_ARM));
        TEST_ASSERT_TRUE(bench_until(0, AXIS_RUNNING));
        bench_rounds(rounds);
        fake_pass(31000);
        fake_estop(false);
        round_poll();
        bench_rounds(100);
        TEST_ASSERT_EQUAL_UINT16(FAULT_estop, fault());
        TEST_ASSERT_EQUAL_UINT8(0, faults_record()->axis);
        TEST_ASSERT_EQUAL_UINT32(axes_get(0)->ledger.pixel + 1u, faults_record()->pixel);
    }
}

static void estop_may_be_inverted(void)
{
    bench_settings()->inputs_inverted = 4;
    fake_estop(false);
    bench_rounds(3);
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(0, COMMAND_CLEAR_FAULT));
    run_a_line();
    TEST_ASSERT_EQUAL_HEX16(0, bench_input(REG_INPUT_status) & 0x10u);
    fake_estop(true);
    bench_rounds(3);
    TEST_ASSERT_EQUAL_UINT16(FAULT_estop, fault());
    TEST_ASSERT_EQUAL_HEX16(0x10, bench_input(REG_INPUT_status) & 0x10u);
}

// An input that is tripped from the start makes no edge.
static void estop_tripped_from_the_start(void)
{
    fake_power_on();
    fake_estop(false);
    board_start();
    time_check_start();
    safety_start();
    estop_release();
    bench_rounds(3);
    TEST_ASSERT_EQUAL_UINT16(FAULT_estop, fault());
}

static void permit_needs_a_sound_machine(void)
{
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(0, COMMAND_PERMIT_ON));
    TEST_ASSERT_TRUE(fake_permit);
    TEST_ASSERT_EQUAL_HEX16(0x100, bench_input(REG_INPUT_outputs));
    TEST_ASSERT_EQUAL_HEX16(0x21, bench_input(REG_INPUT_status) | 1u);
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(0, COMMAND_PERMIT_OFF));
    TEST_ASSERT_FALSE(fake_permit);
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(0, COMMAND_PERMIT_ON));
    faults_latch(FAULT_starved, 0, 0);
    TEST_ASSERT_FALSE(fake_permit);
    TEST_ASSERT_EQUAL_HEX16(0, bench_input(REG_INPUT_outputs));
}

static void a_stop_takes_the_permit_away(void)
{
    run_a_line();
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(0, COMMAND_PERMIT_ON));
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(1, COMMAND_STOP));
    TEST_ASSERT_FALSE(fake_permit);
    TEST_ASSERT_EQUAL_UINT16(FAULT_none, fault());
}

static void a_silent_bus_stops_what_moves(void)
{
    bench_settings()->bus_timeout_ms = 400;
    run_a_line();
    TEST_ASSERT_EQUAL_UINT16(FAULT_none, fault());
    pass_ms(400);
    TEST_ASSERT_EQUAL_UINT16(FAULT_bus_silent, fault());
    TEST_ASSERT_EQUAL_UINT16(400, bench_input(REG_INPUT_fault_argument));
    bench_rounds(10);
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(0, COMMAND_CLEAR_FAULT));
    pass_ms(500); // nothing moves
    TEST_ASSERT_EQUAL_UINT16(FAULT_none, fault());
}

static void queue_chained(uint8_t axis, uint16_t pixels)
{
    (void)bench_entry(axis, LINE_MARK_START, 0);
    (void)bench_entry(axis, 0, 0);
    (void)bench_entry(axis, 10, pixels);
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_entry(axis, LINE_MARK_END, 0));
}

static void wait_when_silent(void)
{
    bench_settings()->bus_timeout_ms = PIXELS_MS(400);
    bench_settings()->silence_waits = 1;
    run_a_line(); // of 500 pixels
    queue_chained(0, 100);
}

static void a_silent_bus_lets_a_line_end(void)
{
    wait_when_silent();
    pass_ms(PIXELS_MS(440));
    TEST_ASSERT_EQUAL_UINT16(FAULT_none, fault());
    TEST_ASSERT_EQUAL_UINT8(AXIS_RUNNING, axes_get(0)->life.state);
    pass_ms(PIXELS_MS(200));
    TEST_ASSERT_EQUAL_UINT16(FAULT_bus_silent, fault());
    TEST_ASSERT_EQUAL_UINT16(PIXELS_MS(400), bench_input(REG_INPUT_fault_argument));
    TEST_ASSERT_EQUAL_UINT8(AXIS_LOADED, axes_get(0)->life.state);
    TEST_ASSERT_EQUAL_INT32(5000, fake_axes[0].steps);
    pass_ms(PIXELS_MS(300));
    TEST_ASSERT_EQUAL_INT32(5000, fake_axes[0].steps);
    // Somebody clears the fault and goes on.
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(0, COMMAND_CLEAR_FAULT));
    traffic_note_request();
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(1, COMMAND_ARM));
    TEST_ASSERT_TRUE(bench_until(0, AXIS_DONE));
    TEST_ASSERT_EQUAL_INT32(6000, fake_axes[0].steps);
    TEST_ASSERT_EQUAL_UINT16(FAULT_none, fault());
}

static void a_bus_that_speaks_again_lets_lines_go_on(void)
{
    wait_when_silent();
    pass_ms(PIXELS_MS(440));
    traffic_note_request();
    TEST_ASSERT_TRUE(bench_until(0, AXIS_DONE));
    TEST_ASSERT_EQUAL_INT32(6000, fake_axes[0].steps);
    TEST_ASSERT_EQUAL_UINT16(FAULT_none, fault());
}

// What was armed and has not begun has no line to end.
static void a_silent_bus_disarms_what_waits(void)
{
    bench_settings()->bus_timeout_ms = 400;
    bench_settings()->silence_waits = 1;
    bench_plain_line(0, 10, 50);
    TEST_ASSERT_EQUAL(MODBUS_OK, order(1, COMMAND_ARM, TOKEN));
    pass_ms(450);
    TEST_ASSERT_EQUAL_UINT16(FAULT_bus_silent, fault());
    TEST_ASSERT_EQUAL_UINT8(AXIS_FAULT, axes_get(0)->life.state);
}

static void go_needs_the_token_and_somebody_who_waits(void)
{
    TEST_ASSERT_EQUAL(MODBUS_DEVICE_FAILURE, order(0, COMMAND_GO, TOKEN));
    bench_plain_line(0, 10, 50);
    TEST_ASSERT_EQUAL(MODBUS_OK, order(1, COMMAND_ARM, TOKEN));
    pass_ms(40);
    TEST_ASSERT_EQUAL_UINT8(AXIS_ARMED, axes_get(0)->life.state);
    TEST_ASSERT_EQUAL(MODBUS_OK, order(0, COMMAND_MARK, 0));
    TEST_ASSERT_EQUAL(MODBUS_OK, order(0, COMMAND_GO, TOKEN));
    TEST_ASSERT_TRUE(bench_until(0, AXIS_RUNNING));
    TEST_ASSERT_TRUE(bench_until(0, AXIS_DONE));
    TEST_ASSERT_EQUAL_INT32(500, fake_axes[0].steps);
}

static void another_token_is_a_fault(void)
{
    bench_plain_line(0, 10, 50);
    TEST_ASSERT_EQUAL(MODBUS_OK, order(1, COMMAND_ARM, TOKEN));
    TEST_ASSERT_EQUAL(MODBUS_OK, order(0, COMMAND_GO, TOKEN + 1));
    TEST_ASSERT_EQUAL_UINT16(FAULT_wrong_token, fault());
    TEST_ASSERT_EQUAL_UINT16(TOKEN + 1, bench_input(REG_INPUT_fault_argument));
    TEST_ASSERT_EQUAL_HEX16(1, bench_input(REG_INPUT_fault_mask_high));
    TEST_ASSERT_EQUAL_HEX16(0, bench_input(REG_INPUT_fault_mask));
    pass_ms(40);
    TEST_ASSERT_EQUAL_INT32(0, fake_axes[0].steps);
}

// With one axis armed by a token another may be armed by the same one only.
static void armed_axes_have_one_token(void)
{
    bench_plain_line(0, 10, 50);
    bench_plain_line(1, 10, 50);
    TEST_ASSERT_EQUAL(MODBUS_OK, order(1, COMMAND_ARM, TOKEN));
    TEST_ASSERT_EQUAL(MODBUS_DEVICE_FAILURE, order(2, COMMAND_ARM, 0));
    TEST_ASSERT_EQUAL(MODBUS_DEVICE_FAILURE, order(2, COMMAND_ARM, TOKEN + 1));
    pass_ms(100);
    TEST_ASSERT_EQUAL_INT32(0, fake_axes[0].steps);
    TEST_ASSERT_EQUAL(MODBUS_OK, order(2, COMMAND_ARM, TOKEN));
    TEST_ASSERT_EQUAL(MODBUS_OK, order(0, COMMAND_MARK, 0));
    pass_ms(40);
    TEST_ASSERT_EQUAL(MODBUS_OK, order(0, COMMAND_MARK, 0));
    TEST_ASSERT_EQUAL(MODBUS_OK, order(0, COMMAND_GO, TOKEN));
    TEST_ASSERT_TRUE(bench_until(0, AXIS_DONE));
    TEST_ASSERT_TRUE(bench_until(1, AXIS_DONE));
    TEST_ASSERT_EQUAL_INT32(500, fake_axes[1].steps);
}

static void an_axis_that_runs_needs_the_clock_while_another_waits_for_go(void)
{
    bench_plain_line(1, 10, 50);
    run_a_line();
    TEST_ASSERT_EQUAL(MODBUS_OK, order(2, COMMAND_ARM, TOKEN));
    bench_clock_off();
    pass_ms(300);
    TEST_ASSERT_EQUAL_UINT16(FAULT_pixel_clock_missing, fault());
}

// The line would run and count steps without moving the motor.
static void the_driver_of_an_armed_axis_stays_on(void)
{
    bench_plain_line(0, 10, 50);
    TEST_ASSERT_EQUAL(MODBUS_OK, order(1, COMMAND_ARM, TOKEN));
    TEST_ASSERT_EQUAL(MODBUS_DEVICE_FAILURE, bench_command(1, COMMAND_DISABLE));
    TEST_ASSERT_TRUE(fake_axes[0].enabled);
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(1, COMMAND_DISARM));
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(1, COMMAND_DISABLE));
    TEST_ASSERT_FALSE(fake_axes[0].enabled);
}

// The pixel clock may stand still until all boards are ready.
static void waiting_for_go_has_patience_with_the_clock(void)
{
    pass_ms(10);
    bench_plain_line(0, 10, 50);
    bench_clock_off();
    TEST_ASSERT_EQUAL(MODBUS_OK, order(1, COMMAND_ARM, TOKEN));
    pass_ms(300);
    TEST_ASSERT_EQUAL_UINT16(FAULT_none, fault());
    TEST_ASSERT_EQUAL(MODBUS_OK, order(0, COMMAND_MARK, 0));
    TEST_ASSERT_EQUAL(MODBUS_OK, order(0, COMMAND_GO, TOKEN));
    pass_ms(300);
    TEST_ASSERT_EQUAL_UINT16(FAULT_none, fault());
    bench_clock_on();
    TEST_ASSERT_TRUE(bench_until(0, AXIS_DONE));
    TEST_ASSERT_EQUAL_INT32(500, fake_axes[0].steps);
}

// From the first edge after `go` on the clock must not stop again.
static void a_clock_that_stops_before_line_zero_is_a_fault(void)
{
    bench_plain_line(0, 10, 50);
    TEST_ASSERT_EQUAL(MODBUS_OK, order(1, COMMAND_ARM, TOKEN));
    pass_ms(40);
    TEST_ASSERT_EQUAL(MODBUS_OK, order(0, COMMAND_MARK, 0));
    TEST_ASSERT_EQUAL(MODBUS_OK, order(0, COMMAND_GO, TOKEN));
    pass_ms(5);
    bench_clock_off();
    pass_ms(3);
    TEST_ASSERT_EQUAL_UINT16(FAULT_pixel_clock_missing, fault());
    TEST_ASSERT_EQUAL_INT32(0, fake_axes[0].steps);
}

static void check_drivers(uint16_t on)
{
    TEST_ASSERT_EQUAL_HEX16(on, bench_input(REG_INPUT_outputs));
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        TEST_ASSERT_EQUAL(((uint16_t)(on >> i) & 1u) != 0, fake_axes[i].enabled);
    }
}

static void arming_switches_the_driver_on_and_rest_off(void)
{
    bench_settings()->idle_off_ms = 100;
    bench_plain_line(0, 10, 5);
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(1, COMMAND_ARM));
    check_drivers(0x1);
    TEST_ASSERT_TRUE(bench_until(0, AXIS_DONE));
    // The time that was set, and 15 ms in which the last step may not be over.
    pass_ms(105);
    check_drivers(0x1);
    pass_ms(20);
    check_drivers(0);
}

static void a_driver_that_rests_goes_off_to_the_millisecond(void)
{
    bench_settings()->idle_off_ms = 100;
    pass_ms(200);
    uint16_t enabled_ms = (uint16_t)(clock_now_ms() + 1u);
    while (clock_now_ms() != enabled_ms) {
        fake_pass(CLOCK_UNIT_TICKS);
    }
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(1, COMMAND_ENABLE));
    uint32_t due_ticks = fake_now_ticks();
    while (fake_axes[0].enabled) {
        if ((uint16_t)(clock_now_ms() - enabled_ms) < 116u) {
            due_ticks = fake_now_ticks() + BENCH_ROUND_TICKS;
        }
        bench_rounds(1);
    }
    // The millisecond behind, and up to four rounds until it is looked at.
    TEST_ASSERT_EQUAL_UINT16(116, (uint16_t)(clock_now_ms() - enabled_ms));
    TEST_ASSERT_TRUE(fake_now_ticks() - due_ticks <= 6000u);
}

static void a_driver_gets_its_time_before_the_first_step(void)
{
    bench_settings()->enable_settle_ms = 200;
    pass_ms(1000); // that is not counted
    bench_plain_line(0, 10, 5);
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(1, COMMAND_ARM));
    uint32_t armed_ticks = fake_now_ticks();
    TEST_ASSERT_TRUE(bench_until(0, AXIS_DONE));
    TEST_ASSERT_TRUE(fake_axes[0].first_step_ticks - armed_ticks >= 200uL * 16000uL);
    TEST_ASSERT_TRUE(fake_axes[0].first_step_ticks - armed_ticks < 300uL * 16000uL);
}

static void reset_by(uint8_t cause, uint16_t expected)
{
    setUp();
    fake_reset_cause = cause;
    safety_start();
    TEST_ASSERT_EQUAL_UINT16(expected, fault());
    TEST_ASSERT_EQUAL_UINT16(cause, bench_input(REG_INPUT_reset_cause));
}

static void resets_that_nobody_asked_for(void)
{
    reset_by(0x01, FAULT_none);
    reset_by(0x02, FAULT_none);
    reset_by(0x05, FAULT_none); // a supply that came up slowly
    reset_by(0x04, FAULT_reset);
    TEST_ASSERT_EQUAL_UINT16(4, bench_input(REG_INPUT_fault_argument));
    reset_by(0x08, FAULT_reset);
    bench_plain_line(0, 10, 5);
    TEST_ASSERT_EQUAL(MODBUS_DEVICE_FAILURE, bench_command(1, COMMAND_ARM));
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(0, COMMAND_CLEAR_FAULT));
}

static void a_stack_that_grew_too_far(void)
{
    run_a_line();
    fake_stack_intact = false;
    bench_rounds(1);
    TEST_ASSERT_EQUAL_UINT16(FAULT_stack_overflow, fault());
    TEST_ASSERT_EQUAL(MODBUS_DEVICE_FAILURE, bench_command(0, COMMAND_CLEAR_FAULT));
}

static void the_watchdog_wants_every_axis(void)
{
    bench_rounds(200);
    TEST_ASSERT_TRUE(fake_watchdog_feeds > 1);
    run_a_line();
    fake_hang_axis(0);
    bench_rounds(CONFIG_AXES);
    uint16_t feeds = fake_watchdog_feeds;
    bench_rounds(200);
    TEST_ASSERT_EQUAL_UINT16(feeds, fake_watchdog_feeds);
}

// Its interrupt is off until the fault is cleared.
static void the_watchdog_excuses_an_underrun(void)
{
    run_a_line();
    fake_underrun(0);
    bench_rounds(10);
    TEST_ASSERT_EQUAL_UINT16(FAULT_underrun, fault());
    uint16_t feeds = fake_watchdog_feeds;
    bench_rounds(200);
    TEST_ASSERT_TRUE(fake_watchdog_feeds > feeds);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(estop_halts_latches_and_wants_a_clear);
    RUN_TEST(estop_names_the_pixel_that_was_reached);
    RUN_TEST(estop_may_be_inverted);
    RUN_TEST(estop_tripped_from_the_start);
    RUN_TEST(permit_needs_a_sound_machine);
    RUN_TEST(a_stop_takes_the_permit_away);
    RUN_TEST(a_silent_bus_stops_what_moves);
    RUN_TEST(a_silent_bus_lets_a_line_end);
    RUN_TEST(a_bus_that_speaks_again_lets_lines_go_on);
    RUN_TEST(a_silent_bus_disarms_what_waits);
    RUN_TEST(go_needs_the_token_and_somebody_who_waits);
    RUN_TEST(another_token_is_a_fault);
    RUN_TEST(armed_axes_have_one_token);
    RUN_TEST(an_axis_that_runs_needs_the_clock_while_another_waits_for_go);
    RUN_TEST(the_driver_of_an_armed_axis_stays_on);
    RUN_TEST(waiting_for_go_has_patience_with_the_clock);
    RUN_TEST(a_clock_that_stops_before_line_zero_is_a_fault);
    RUN_TEST(arming_switches_the_driver_on_and_rest_off);
    RUN_TEST(a_driver_that_rests_goes_off_to_the_millisecond);
    RUN_TEST(a_driver_gets_its_time_before_the_first_step);
    RUN_TEST(resets_that_nobody_asked_for);
    RUN_TEST(a_stack_that_grew_too_far);
    RUN_TEST(the_watchdog_wants_every_axis);
    RUN_TEST(the_watchdog_excuses_an_underrun);
    return UNITY_END();
}
