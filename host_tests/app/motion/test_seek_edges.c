// SPDX-License-Identifier: MIT
// The edge that a seek captures, beside edges of the pixel clock and inside long intervals.
#include <stdint.h>

#include "app/motion/seek.h"
#include "app/round.h"
#include "fakes/board.h"
#include "hal/pixel_clock.h"
#include "hal/step_timer.h"
#include "hal/switches.h"
#include "seek_bench.h"
#include "unity.h"
#include "wire/register_map.h"

// A clock edge is captured with the clock's axis as it is then, the switch's with the axis that
// seeks. Where that is one and the same, the account must not pass the older of both.
static void check_trip(uint32_t ticks, int32_t steps)
{
    TEST_ASSERT_EQUAL(FAULT_none, faults_record()->code);
    TEST_ASSERT_EQUAL_UINT16(TRIP_CLOSED, bench_input(REG_INPUT_trip_code));
    TEST_ASSERT_EQUAL_UINT32(ticks, bench_input_wide(REG_INPUT_trip_ticks));
    TEST_ASSERT_EQUAL_INT32(steps,
                            (int32_t)bench_input_wide(REG_INPUT_trip_position_steps));
}

// The clock has been noticed, but its edge was not placed.
static void check_clock_edge_is_ignored(void)
{
    TEST_ASSERT_FALSE(pixel_clock_waiting());
    TEST_ASSERT_FALSE(reference_overdue());
    TEST_ASSERT_FALSE(reference_watch()->known);
}

static void start_on_the_clocks_axis(void)
{
    setUp();
    queue_seek(CONFIG_PIXEL_CLOCK_AXIS, 0, 1, 200);
    start_seek(CONFIG_PIXEL_CLOCK_AXIS);
    go_to(CONFIG_PIXEL_CLOCK_AXIS, 408000); // half a pixel before an edge
    round_poll();
}

// The switch closes at this tick; then so much time passes without a round.
static void close_at(uint8_t axis, uint32_t ticks, uint32_t then_ticks)
{
    fake_pass(ticks - fake_now_ticks());
    fake_switch(axis, SWITCH_HOME, CLOSED);
    fake_pass(then_ticks);
    TEST_ASSERT_TRUE(pixel_clock_waiting());
    // A command that asks for the account now must wait.
    TEST_ASSERT_FALSE(axes_advance(axis, LEDGER_EXACTLY));
    TEST_ASSERT_FALSE(axes_advance(CONFIG_SWITCH_CAPTURE_AXIS, LEDGER_EXACTLY));
}

static void seek_on_the_clocks_axis(uint32_t trip, uint32_t then_ticks)
{
    uint32_t zero = axes_get(CONFIG_PIXEL_CLOCK_AXIS)->zero_ticks;

    close_at(CONFIG_PIXEL_CLOCK_AXIS, trip, then_ticks);
    round_poll();
    check_clock_edge_is_ignored();
    TEST_ASSERT_TRUE(axes_advance(CONFIG_PIXEL_CLOCK_AXIS, LEDGER_EXACTLY));
    TEST_ASSERT_TRUE(bench_until(CONFIG_PIXEL_CLOCK_AXIS, AXIS_DONE));
    check_trip(trip, steps_at(trip - zero));
}

static void clock_edge_and_switch_edge_wait_together(void)
{
    static const uint16_t apart[] = {0, 1, 300, 1999, 5000};

    for (uint8_t i = 0; i < (uint8_t)(sizeof apart / sizeof apart[0]); i++) {
        start_on_the_clocks_axis();
        seek_on_the_clocks_axis(fake_next_edge_ticks() + apart[i], 100);
        start_on_the_clocks_axis();
        seek_on_the_clocks_axis(fake_next_edge_ticks() - apart[i], apart[i] + 100u);
    }
}

// It comes between the two looks of a round: the switch's edge is taken first, then it is too old.
static void clock_edge_between_two_looks_is_ignored(void)
{
    start_on_the_clocks_axis();
    uint32_t trip = fake_next_edge_ticks() + 500u;
    uint32_t zero = axes_get(CONFIG_PIXEL_CLOCK_AXIS)->zero_ticks;
    fake_pass(trip - fake_now_ticks());
    fake_switch(CONFIG_PIXEL_CLOCK_AXIS, SWITCH_HOME, CLOSED);
    fake_pass(1000);
    seek_poll();
    check_clock_edge_is_ignored();
    TEST_ASSERT_TRUE(bench_until(CONFIG_PIXEL_CLOCK_AXIS, AXIS_DONE));
    check_trip(trip, steps_at(trip - zero));
}

// Only the axis of its timer has a sample in a clock edge.
static void clock_edge_that_waits_holds_up_its_own_axis_only(void)
{
    fake_pass(fake_next_edge_ticks() + 100u - fake_now_ticks());
    TEST_ASSERT_TRUE(pixel_clock_waiting());
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        TEST_ASSERT_EQUAL(i != CONFIG_PIXEL_CLOCK_AXIS, axes_advance(i, LEDGER_EXACTLY));
    }
    round_poll();
    TEST_ASSERT_TRUE(axes_advance(CONFIG_PIXEL_CLOCK_AXIS, LEDGER_EXACTLY));
}

// Another axis seeks: both edges count.
static void clock_edge_beside_a_seek_of_another_axis_counts(void)
{
    queue_seek(BENCH_SECOND, 0, 1, 200);
    start_seek(BENCH_SECOND);
    go_to(BENCH_SECOND, 408000);
    round_poll();
    uint32_t edge = fake_next_edge_ticks();
    close_at(BENCH_SECOND, edge, 3000);
    round_poll();
    TEST_ASSERT_FALSE(reference_overdue());
    TEST_ASSERT_TRUE(reference_watch()->known);
    TEST_ASSERT_TRUE(bench_until(BENCH_SECOND, AXIS_DONE));
    check_trip(edge, steps_at(edge - axes_get(BENCH_SECOND)->zero_ticks));
}

// A long interval is made of several periods, of which one carries the step.
static void edge_inside_a_long_interval(void)
{
    bench_settings()->pixel_hz_num[1] = BENCH_PIXEL_HZ / 100u;
    limits_apply_settings();
    bench_clock_off();
    queue_seek(0, 0, 1, 40);
    start_seek(0);
    bench_rounds(3200); // three pixels
    for (uint8_t i = 0; i < 3; i++) {
        int32_t steps = fake_axes[0].steps;
        while (fake_axes[0].steps == steps) {
            bench_rounds(1);
        }
        // A fifth of the interval is over: the next period but one has no step either.
        bench_rounds(30);
    }
    int32_t before = fake_axes[0].steps;
    fake_switch(0, SWITCH_HOME, CLOSED);
    bench_rounds(10);
    TEST_ASSERT_EQUAL_INT32(before, fake_axes[0].steps);
    TEST_ASSERT_TRUE(bench_until(0, AXIS_DONE));
    TEST_ASSERT_EQUAL_UINT16(TRIP_CLOSED, bench_input(REG_INPUT_trip_code));
    TEST_ASSERT_EQUAL_INT32(before,
                            (int32_t)bench_input_wide(REG_INPUT_trip_position_steps));
}

// The axis that seeks and the one whose timer captures the switch; the others rest without.
static void interrupts_that_a_seek_needs_go_on(void)
{
    queue_seek(BENCH_LAST, 0, 1, 200);
    start_seek(BENCH_LAST);
    if (BENCH_SECOND != CONFIG_SWITCH_CAPTURE_AXIS) { // a line that ends meanwhile
        bench_plain_line(BENCH_SECOND, 5, 2);
        TEST_ASSERT_EQUAL(MODBUS_OK,
                          bench_command(BENCH_MASK_OF(BENCH_SECOND), COMMAND_ARM));
        TEST_ASSERT_TRUE(bench_until(BENCH_SECOND, AXIS_DONE));
    }
    bench_rounds(60);
    TEST_ASSERT_EQUAL(AXIS_RUNNING, axes_get(BENCH_LAST)->life.state);
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        bool needed = i == BENCH_LAST || i == CONFIG_SWITCH_CAPTURE_AXIS;
        TEST_ASSERT_EQUAL(!needed, step_timer_state(i) == STEP_ENGINE_PARKED);
    }
    fake_switch(BENCH_LAST, SWITCH_HOME, CLOSED);
    TEST_ASSERT_TRUE(bench_until(BENCH_LAST, AXIS_DONE));
    bench_rounds(60);
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        TEST_ASSERT_EQUAL(STEP_ENGINE_PARKED, step_timer_state(i));
    }
}

int main(void)
{
    UNITY_BEGIN();

    RUN_TEST(clock_edge_and_switch_edge_wait_together);
    RUN_TEST(clock_edge_between_two_looks_is_ignored);
    RUN_TEST(clock_edge_that_waits_holds_up_its_own_axis_only);
    RUN_TEST(clock_edge_beside_a_seek_of_another_axis_counts);
    RUN_TEST(edge_inside_a_long_interval);
    if (SEVERAL_AXES) {
        RUN_TEST(interrupts_that_a_seek_needs_go_on);
    }
    return UNITY_END();
}
