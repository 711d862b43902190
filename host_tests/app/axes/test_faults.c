// SPDX-License-Identifier: MIT
// Every named fault over the fake board: it is latched, nothing moves after it, and
// clear_fault makes the machine work again with its positions kept.
#include <stdint.h>

#include "base/require.h"
#include "fakes/board.h"
#include "fakes/board_bench.h"
#include "hal/pixel_clock.h"
#include "hal/step_timer.h"
#include "nothing_moves.h"
#include "unity.h"

void setUp(void)
{
    bench_power_on();
}

void tearDown(void)
{
}

static void arm(uint16_t mask)
{
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(mask, COMMAND_ARM));
}

static void start_plain(uint8_t axis, int16_t count, uint16_t pixels)
{
    bench_plain_line(axis, count, pixels);
    arm((uint16_t)(1u << axis));
    TEST_ASSERT_TRUE(bench_until(axis, AXIS_RUNNING));
}

static void slow_pixels(void)
{
    bench_settings()->pixel_hz_num[1] = BENCH_SLOW_HZ;
    limits_apply_settings();
    fake_pixel_clock(5000, BENCH_SLOW_HZ, 1);
    bench_rounds(10);
}

// No axis is armed either.
static void check_all_at_rest(void)
{
    check_nothing_moves();
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        TEST_ASSERT_NOT_EQUAL(AXIS_RUNNING, axes_get(i)->life.state);
        TEST_ASSERT_FALSE(lifecycle_armed(&axes_get(i)->life));
    }
}

static void check_fault(enum fault code, uint8_t axis)
{
    TEST_ASSERT_EQUAL(code, faults_record()->code);
    TEST_ASSERT_EQUAL_UINT8(axis, faults_record()->axis);
    TEST_ASSERT_EQUAL_HEX16(1u << (uint8_t)code, faults_record()->mask);
    TEST_ASSERT_EQUAL_HEX8(0, bench_axes_in(AXIS_STARTING));
}

// A line runs from the kept position on the clock edges as they come.
static void check_new_line(uint8_t axis)
{
    int32_t steps = fake_axes[axis].steps;

    bench_rounds(50);
    fake_axes[axis].first_step_ticks = 0;
    bench_plain_line(axis, 8, 2);
    arm((uint16_t)(1u << axis));
    TEST_ASSERT_TRUE(bench_until(axis, AXIS_DONE));
    TEST_ASSERT_EQUAL(FAULT_none, faults_record()->code);
    TEST_ASSERT_EQUAL_INT32(steps + 16, fake_axes[axis].steps);
    TEST_ASSERT_EQUAL_INT32(steps + 16, ledger_position(&axes_get(axis)->ledger));
    uint32_t since_first = fake_next_edge_ticks() - fake_axes[axis].first_step_ticks;
    uint32_t pixel_ticks = reference_period()->whole_ticks;
    TEST_ASSERT_EQUAL_UINT32(pixel_ticks - pixel_ticks / 8u, since_first % pixel_ticks);
}

static void check_recovery(uint8_t axis)
{
    check_all_at_rest();
    bench_plain_line(BENCH_THIRD, 4, 1);
    TEST_ASSERT_EQUAL(MODBUS_DEVICE_FAILURE,
                      bench_command(BENCH_MASK_OF(BENCH_THIRD), COMMAND_ARM));
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(0, COMMAND_CLEAR_FAULT));
    TEST_ASSERT_EQUAL(FAULT_none, faults_record()->code);
    TEST_ASSERT_EQUAL_HEX16(0, faults_record()->mask);
    TEST_ASSERT_EQUAL(AXIS_EMPTY, axes_get(axis)->life.state);
    TEST_ASSERT_EQUAL_INT32(fake_axes[axis].steps,
                            ledger_position(&axes_get(axis)->ledger));
    TEST_ASSERT_EQUAL(MODBUS_OK,
                      bench_command(BENCH_MASK_OF(BENCH_THIRD), COMMAND_DISCARD));
    check_new_line(axis);
}

static void starved(void)
{
    int32_t queued = bench_long_start(0);

    arm(1);
    TEST_ASSERT_TRUE(bench_until(0, AXIS_FAULT));
    check_fault(FAULT_starved, 0);
    // The step on the last edge has nothing behind it that could carry it.
    TEST_ASSERT_EQUAL_INT32(queued - 1, fake_axes[0].steps);
    check_recovery(0);
}

static void decoder_late(void)
{
    slow_pixels();
    // 512.8 ticks a step make no pulse train (feed_fits_train()), so that the ring holds less than
    // a pixel.
    start_plain(1, 312, 20);
    bench_rounds(100);
    fake_pass(155000uL);
    bench_rounds(1);
    check_fault(FAULT_decoder_late, 1);
    TEST_ASSERT_EQUAL(AXIS_FAULT, axes_get(1)->life.state);
    TEST_ASSERT_TRUE(fake_axes[1].steps > 0 && fake_axes[1].steps < 6240);
    check_recovery(1);
}

static void underrun(void)
{
    start_plain(0, 10, 100);
    bench_plain_line(1, 10, 100);
    arm(2);
    TEST_ASSERT_TRUE(bench_until(1, AXIS_RUNNING));
    bench_rounds(20);
    fake_underrun(1);
    bench_rounds(1);
    check_fault(FAULT_underrun, 1);
    TEST_ASSERT_EQUAL_UINT16(1, axes_get(1)->underruns);
    TEST_ASSERT_TRUE(faults_time_lost());
    TEST_ASSERT_EQUAL(AXIS_FAULT, axes_get(0)->life.state);
    check_recovery(1);
    TEST_ASSERT_FALSE(faults_time_lost());
    check_new_line(0);
}

// Every timer begins again at the start of its ring, also those of axes that were not involved.
static void restart_of_time_begins_every_ring_again(void)
{
    start_plain(0, 10, 3);
    TEST_ASSERT_TRUE(bench_until(0, AXIS_DONE));
    bench_plain_line(BENCH_THIRD, 10, 3);
    fake_underrun(BENCH_LAST);
    bench_rounds(1);
    check_fault(FAULT_underrun, BENCH_LAST);
    TEST_ASSERT_EQUAL(AXIS_LOADED, axes_get(BENCH_THIRD)->life.state);
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(0, COMMAND_CLEAR_FAULT));
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        TEST_ASSERT_EQUAL(AXIS_EMPTY, axes_get(i)->life.state);
        TEST_ASSERT_EQUAL_UINT8(0, axis_ring_fill(axes_get(i)));
    }
    check_new_line(0);
    check_new_line(BENCH_THIRD);
}

// It was captured when time began earlier.
static void clock_edge_that_waits_does_not_survive_a_restart(void)
{
    bench_rounds(1000); // the time before was longer
    fake_underrun(1);
    bench_rounds(3);
    check_fault(FAULT_underrun, 1);
    fake_pass(BENCH_PIXEL_TICKS);
    TEST_ASSERT_TRUE(pixel_clock_waiting());
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(0, COMMAND_CLEAR_FAULT));
    bench_rounds(200);
    uint32_t behind = axes_get(0)->ledger.loaded_ticks -
                      axes_get(CONFIG_PIXEL_CLOCK_AXIS)->ledger.loaded_ticks;
    TEST_ASSERT_TRUE(behind + 0x40000u < 0x80000u);
    check_new_line(0);
}

// In the middle of a line of the third axis.
static void miss_a_period(void)
{
    slow_pixels();
    start_plain(BENCH_THIRD, 400, 20);
    bench_rounds(200);
    TEST_ASSERT_EQUAL(FAULT_none, faults_record()->code);
    fake_missed_period(BENCH_THIRD);
}

// The one overflow flag cannot tell of a whole period without its interrupt; time can.
static void period_without_interrupt(void)
{
    miss_a_period();
    bench_rounds(1000);
    check_fault(FAULT_underrun, BENCH_THIRD);
    TEST_ASSERT_TRUE(faults_time_lost());
    check_recovery(BENCH_THIRD);
    TEST_ASSERT_FALSE(faults_time_lost());
}

// A halt comes before the check of time would have its turn.
static void missed_period_before_a_stop(void)
{
    miss_a_period();
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(1u << BENCH_THIRD, COMMAND_STOP));
    TEST_ASSERT_EQUAL(FAULT_none, faults_record()->code);
    TEST_ASSERT_TRUE(bench_until(BENCH_THIRD, AXIS_EMPTY));
    TEST_ASSERT_EQUAL(FAULT_underrun, faults_record()->code);
    TEST_ASSERT_EQUAL_UINT8(BENCH_THIRD, faults_record()->axis);
    TEST_ASSERT_TRUE(faults_time_lost());
}

// The same beside another fault: it is named beside that one within some milliseconds, or anew
// where that one is cleared before.
static void missed_period_before_another_fault(void)
{
    miss_a_period();
    faults_latch(FAULT_starved, BENCH_THIRD, 0);
    bench_rounds(1000);
    TEST_ASSERT_EQUAL(FAULT_starved, faults_record()->code);
    TEST_ASSERT_TRUE((faults_record()->mask >> FAULT_underrun & 1u) != 0);
    check_recovery(BENCH_THIRD);
}

static void missed_period_before_a_fault_that_is_cleared_at_once(void)
{
    miss_a_period();
    faults_latch(FAULT_starved, BENCH_THIRD, 0);
    do {
        fake_pass(BENCH_ROUND_TICKS);
    } while (bench_command(0, COMMAND_CLEAR_FAULT) != MODBUS_OK);
    TEST_ASSERT_EQUAL(FAULT_none, faults_record()->code);
    bench_rounds(1000);
    TEST_ASSERT_EQUAL(FAULT_underrun, faults_record()->code);
}

// The check of time, before the round takes what the interrupt has noted of the same period.
static void underrun_seen_twice_counts_once(void)
{
    start_plain(BENCH_THIRD, 10, 100);
    bench_rounds(20);
    fake_underrun(BENCH_THIRD);
    faults_latch_underrun(BENCH_THIRD);
    bench_rounds(3);
    check_fault(FAULT_underrun, BENCH_THIRD);
    TEST_ASSERT_EQUAL_UINT16(1, axes_get(BENCH_THIRD)->underruns);
    check_recovery(BENCH_THIRD);
}

// The stop's interrupt delays those of the steps: its fault is the first one.
static void underrun_beside_an_emergency_stop(void)
{
    start_plain(BENCH_THIRD, 10, 100);
    bench_rounds(20);
    fake_estop(false);
    fake_underrun(BENCH_THIRD);
    bench_rounds(3);
    TEST_ASSERT_EQUAL(FAULT_estop, faults_record()->code);
    TEST_ASSERT_EQUAL_UINT8(BENCH_THIRD, faults_record()->axis);
    TEST_ASSERT_BITS_HIGH((uint32_t)1 << FAULT_underrun, faults_record()->mask);
    TEST_ASSERT_EQUAL_UINT16(1, axes_get(BENCH_THIRD)->underruns);
    TEST_ASSERT_TRUE(faults_time_lost());
    fake_estop(true);
    bench_rounds(3);
    check_recovery(BENCH_THIRD);
}

static void underrun_at_rest(void)
{
    fake_underrun(BENCH_LAST);
    bench_rounds(1);
    check_fault(FAULT_underrun, BENCH_LAST);
    TEST_ASSERT_EQUAL(AXIS_EMPTY, axes_get(BENCH_LAST)->life.state);
    check_recovery(BENCH_LAST);
}

static void pixel_clock_missing_in_a_line(void)
{
    start_plain(0, 10, 200);
    bench_rounds(50);
    bench_clock_off();
    TEST_ASSERT_TRUE(bench_until(0, AXIS_FAULT));
    check_fault(FAULT_pixel_clock_missing, 0);
    check_all_at_rest();
    bench_clock_on();
    check_recovery(0);
}

static void pixel_clock_missing_when_armed(void)
{
    bench_clock_off();
    bench_rounds(100);
    bench_plain_line(BENCH_THIRD, 10, 2);
    arm(BENCH_MASK_OF(BENCH_THIRD));
    bench_rounds(10);
    TEST_ASSERT_EQUAL(AXIS_ARMED, axes_get(BENCH_THIRD)->life.state);
    TEST_ASSERT_TRUE(bench_until(BENCH_THIRD, AXIS_FAULT));
    check_fault(FAULT_pixel_clock_missing, BENCH_THIRD);
    TEST_ASSERT_EQUAL_INT32(0, fake_axes[BENCH_THIRD].steps);
    check_all_at_rest();
    bench_clock_on();
    check_recovery(BENCH_THIRD);
}

static void clock_is_not_missed_by_nobody(void)
{
    bench_rounds(50);
    bench_clock_off();
    bench_rounds(200);
    TEST_ASSERT_EQUAL(FAULT_none, faults_record()->code);
    TEST_ASSERT_FALSE(reference_present());
}

// Edges wait for the main loop, and none is lost.
static void clock_edges_wait(void)
{
    start_plain(0, 4, 100);
    bench_rounds(50);
    uint32_t edges = reference_watch()->edges;

    fake_pass(BENCH_PIXEL_TICKS * 4uL);
    bench_rounds(1);
    TEST_ASSERT_EQUAL(FAULT_none, faults_record()->code);
    TEST_ASSERT_EQUAL_UINT32(edges + 4u, reference_watch()->edges);
    TEST_ASSERT_TRUE(bench_until(0, AXIS_DONE));
}

static void clock_edge_lost(void)
{
    start_plain(0, 4, 100);
    bench_rounds(50);
    fake_pass(BENCH_PIXEL_TICKS * (CONFIG_CLOCK_EDGES + 3uL));
    bench_rounds(1);
    check_fault(FAULT_clock_edge_lost, 0);
    TEST_ASSERT_EQUAL_UINT16(3, faults_record()->argument);
    TEST_ASSERT_EQUAL(AXIS_FAULT, axes_get(0)->life.state);
    check_recovery(0);
}

// An edge beside them that was crowded out does not hide their number.
static void clock_edges_lost_and_crowded(void)
{
    start_plain(0, 4, 100);
    bench_rounds(50);
    fake_crowded_edge();
    fake_pass(BENCH_PIXEL_TICKS * (CONFIG_CLOCK_EDGES + 3uL));
    bench_rounds(1);
    check_fault(FAULT_clock_edge_lost, 0);
    TEST_ASSERT_EQUAL_UINT16(3, faults_record()->argument);
    check_recovery(0);
}

// The same where the clock's axis runs, and its edges come where they are planned.
static void clock_edge_lost_beside_edges_that_are_planned(void)
{
    start_plain(CONFIG_PIXEL_CLOCK_AXIS, 4, 100);
    bench_rounds(100);
    fake_pass(BENCH_PIXEL_TICKS * (CONFIG_CLOCK_EDGES + 3uL));
    bench_rounds(1);
    check_fault(FAULT_clock_edge_lost, CONFIG_PIXEL_CLOCK_AXIS);
    TEST_ASSERT_EQUAL_UINT16(3, faults_record()->argument);
    check_recovery(CONFIG_PIXEL_CLOCK_AXIS);
}

static void crowded_clock_edge_beside_edges_that_are_planned(void)
{
    start_plain(CONFIG_PIXEL_CLOCK_AXIS, 4, 100);
    bench_rounds(100);
    fake_crowded_edge();
    bench_rounds(40);
    TEST_ASSERT_NOT_EQUAL(FAULT_none, faults_record()->code);
}

static void start_late(void)
{
    slow_pixels();
    bench_plain_line(0, 10, 3);
    arm(1);
    for (uint8_t i = 0; i < 250 && bench_axes_in(AXIS_STARTING) == 0; i++) {
        bench_rounds(1);
    }
    TEST_ASSERT_EQUAL_HEX8(1, bench_axes_in(AXIS_STARTING));
    fake_pass(175000uL);
    bench_rounds(1);
    check_fault(FAULT_start_late, 0);
    TEST_ASSERT_EQUAL_INT32(0, fake_axes[0].steps);
    check_recovery(0);
}

static void broken_promise_stops_everything(void)
{
    start_plain(0, 10, 100);
    bench_rounds(30);
    require_failed(1234);
    check_fault(FAULT_internal, 0);
    TEST_ASSERT_EQUAL_UINT16(1234, faults_record()->argument);
    check_recovery(0);
}

static void first_fault_stays(void)
{
    start_plain(1, 10, 100);
    bench_rounds(50);
    faults_latch(FAULT_starved, 1, 7);
    faults_latch(FAULT_underrun, 0, 8);
    TEST_ASSERT_EQUAL(FAULT_starved, faults_record()->code);
    TEST_ASSERT_EQUAL_UINT8(1, faults_record()->axis);
    TEST_ASSERT_EQUAL_UINT16(7, faults_record()->argument);
    TEST_ASSERT_EQUAL_HEX16((1u << FAULT_starved) | (1u << FAULT_underrun),
                            faults_record()->mask);
    TEST_ASSERT_EQUAL_UINT32(axes_get(1)->ledger.pixel + 1u, faults_record()->pixel);
}

static void clear_waits_for_the_last_period(void)
{
    start_plain(0, 10, 100);
    bench_rounds(100); // steps are made: no period is longer than theirs
    faults_latch(FAULT_starved, 0, 0);
    TEST_ASSERT_TRUE(step_engine_going(step_timer_state(0)));
    TEST_ASSERT_EQUAL(MODBUS_DEVICE_FAILURE, bench_command(0, COMMAND_CLEAR_FAULT));
    bench_rounds(10);
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(0, COMMAND_CLEAR_FAULT));
    check_new_line(0);
}

static void stop_does_not_hide_a_fault(void)
{
    start_plain(0, 10, 100);
    bench_rounds(50);
    faults_latch(FAULT_starved, 0, 0);
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(1, COMMAND_STOP));
    TEST_ASSERT_EQUAL(FAULT_starved, faults_record()->code);
    TEST_ASSERT_EQUAL(AXIS_FAULT, axes_get(0)->life.state);
    check_recovery(0);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(starved);
    RUN_TEST(decoder_late);
    RUN_TEST(underrun);
    RUN_TEST(period_without_interrupt);
    RUN_TEST(missed_period_before_a_stop);
    RUN_TEST(missed_period_before_another_fault);
    RUN_TEST(missed_period_before_a_fault_that_is_cleared_at_once);
    RUN_TEST(restart_of_time_begins_every_ring_again);
    RUN_TEST(clock_edge_that_waits_does_not_survive_a_restart);
    RUN_TEST(underrun_seen_twice_counts_once);
    RUN_TEST(underrun_beside_an_emergency_stop);
    RUN_TEST(underrun_at_rest);
    RUN_TEST(pixel_clock_missing_in_a_line);
    RUN_TEST(pixel_clock_missing_when_armed);
    RUN_TEST(clock_is_not_missed_by_nobody);
    RUN_TEST(clock_edges_wait);
    RUN_TEST(clock_edge_lost);
    RUN_TEST(clock_edges_lost_and_crowded);
    if (SEVERAL_AXES) {
        RUN_TEST(clock_edge_lost_beside_edges_that_are_planned);
        RUN_TEST(crowded_clock_edge_beside_edges_that_are_planned);
    }
    RUN_TEST(start_late);
    RUN_TEST(broken_promise_stops_everything);
    RUN_TEST(first_fault_stays);
    RUN_TEST(clear_waits_for_the_last_period);
    RUN_TEST(stop_does_not_hide_a_fault);
    return UNITY_END();
}
