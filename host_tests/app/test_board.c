// SPDX-License-Identifier: MIT
// The machine over the fake board: arming, common start, ends, stop, refusals.
#include <stdint.h>

#include "app/registers/report.h"
#include "fakes/board.h"
#include "fakes/board_bench.h"
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

static void at_rest_after_power_on(void)
{
    bench_rounds(100);
    TEST_ASSERT_EQUAL(FAULT_none, faults_record()->code);
    TEST_ASSERT_FALSE(axes_first_moving() != CONFIG_AXES);
    TEST_ASSERT_TRUE(reference_present());
    check_nothing_moves();
}

static void loaded_line_waits_for_arming(void)
{
    bench_plain_line(0, 10, 3);
    TEST_ASSERT_EQUAL(AXIS_LOADED, axes_get(0)->life.state);
    check_nothing_moves();
    TEST_ASSERT_EQUAL(AXIS_LOADED, axes_get(0)->life.state);
}

static void armed_line_runs_to_its_end(void)
{
    bench_rounds(50);
    bench_plain_line(1, 10, 3);
    arm(2);
    TEST_ASSERT_EQUAL(AXIS_ARMED, axes_get(1)->life.state);
    TEST_ASSERT_TRUE(bench_until(1, AXIS_RUNNING));
    TEST_ASSERT_TRUE(bench_until(1, AXIS_DONE));
    TEST_ASSERT_EQUAL_INT32(30, fake_axes[1].steps);
    TEST_ASSERT_EQUAL_INT32(30, ledger_position(&axes_get(1)->ledger));
    TEST_ASSERT_EQUAL_UINT16(1, axes_get(1)->lines_done);
    TEST_ASSERT_EQUAL(FAULT_none, faults_record()->code);
    check_nothing_moves();
}

// A line that does not wait for the clock follows the line before it, unless that one is over.
static void line_after_a_rest_may_go_either_way_at_once(void)
{
    bench_plain_line(1, 40, 3);
    arm(2);
    TEST_ASSERT_TRUE(bench_until(1, AXIS_DONE));
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_entry(1, LINE_MARK_START, 0));
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_entry(1, 0, 0));
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_entry(1, -40, 3));
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_entry(1, LINE_MARK_END, 0));
    arm(2);
    TEST_ASSERT_TRUE(bench_until(1, AXIS_DONE));
    TEST_ASSERT_EQUAL_INT32(0, fake_axes[1].steps);
}

static uint32_t step_ticks(uint8_t axis, uint32_t steps_per_pixel)
{
    return fake_axes[axis].first_step_ticks - BENCH_PIXEL_TICKS / steps_per_pixel;
}

// Line zero is a whole number of pixel periods behind a clock edge: an edge of the exact clock.
static void axes_share_a_zero_on_the_pixel_clock(void)
{
    static const int16_t counts[] = {10, 8, -16, 20};

    bench_rounds(37);
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        bench_plain_line(i, counts[i], 4);
    }
    arm(BENCH_ALL_AXES);
    TEST_ASSERT_TRUE(bench_until(BENCH_LAST, AXIS_DONE));
    bench_rounds(20);
    uint32_t zero_ticks = axes_get(0)->zero_ticks;
    TEST_ASSERT_EQUAL_UINT32(0,
                             (fake_next_edge_ticks() - zero_ticks) % BENCH_PIXEL_TICKS);
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        TEST_ASSERT_EQUAL_UINT32(zero_ticks, axes_get(i)->zero_ticks);
        TEST_ASSERT_EQUAL_INT32(4 * counts[i], fake_axes[i].steps);
        TEST_ASSERT_EQUAL_UINT32(
            zero_ticks,
            step_ticks(i, (uint32_t)(counts[i] < 0 ? -counts[i] : counts[i])));
        TEST_ASSERT_EQUAL_UINT32(zero_ticks + 4u * BENCH_PIXEL_TICKS,
                                 fake_axes[i].last_step_ticks);
    }
}

// When a pixel leaves enough time, line zero is the next edge of the clock.
static void start_is_one_period_after_an_edge(void)
{
    bench_settings()->pixel_hz_num[1] = BENCH_SLOW_HZ;
    limits_apply_settings();
    fake_pixel_clock(5000, BENCH_SLOW_HZ, 1);
    bench_plain_line(0, 10, 1);
    bench_rounds(10);
    arm(1);
    uint32_t edge_ticks = fake_next_edge_ticks();
    TEST_ASSERT_TRUE(bench_until(0, AXIS_DONE));
    TEST_ASSERT_EQUAL_UINT32(edge_ticks + 160000uL, axes_get(0)->zero_ticks);
    TEST_ASSERT_EQUAL_UINT32(edge_ticks + 176000uL, fake_axes[0].first_step_ticks);
    TEST_ASSERT_EQUAL_UINT32(edge_ticks + 320000uL, fake_axes[0].last_step_ticks);
}

static void clock_errors_are_zero_on_an_exact_clock(void)
{
    bench_plain_line(BENCH_LAST, 10, 12);
    arm(BENCH_MASK_OF(BENCH_LAST));
    TEST_ASSERT_TRUE(bench_until(BENCH_LAST, AXIS_DONE));
    TEST_ASSERT_EQUAL_UINT16(0, reference_watch()->error_max_ticks);
    TEST_ASSERT_TRUE(reference_watch()->following);
    TEST_ASSERT_TRUE(reference_watch()->pixel >= 12);
}

static void second_line_waits_for_its_own_arming(void)
{
    bench_plain_line(0, 10, 2);
    bench_plain_line(0, -10, 3);
    arm(1);
    TEST_ASSERT_TRUE(bench_until(0, AXIS_RUNNING));
    TEST_ASSERT_TRUE(bench_until(0, AXIS_LOADED));
    TEST_ASSERT_EQUAL_INT32(20, fake_axes[0].steps);
    check_nothing_moves();
    arm(1);
    TEST_ASSERT_TRUE(bench_until(0, AXIS_DONE));
    TEST_ASSERT_EQUAL_INT32(-10, fake_axes[0].steps);
    TEST_ASSERT_EQUAL_UINT16(2, axes_get(0)->lines_done);
}

static void unclocked_line_starts_without_a_clock(void)
{
    bench_clock_off();
    (void)bench_entry(BENCH_THIRD, LINE_MARK_START, 0);
    (void)bench_entry(BENCH_THIRD, 0, 0);
    (void)bench_entry(BENCH_THIRD, -5, 4);
    (void)bench_entry(BENCH_THIRD, LINE_MARK_END, 0);
    arm(BENCH_MASK_OF(BENCH_THIRD));
    TEST_ASSERT_TRUE(bench_until(BENCH_THIRD, AXIS_DONE));
    TEST_ASSERT_EQUAL_INT32(-20, fake_axes[BENCH_THIRD].steps);
    TEST_ASSERT_EQUAL(FAULT_none, faults_record()->code);
}

static void queue_backlash_line(uint16_t mark)
{
    static const int16_t counts[] = {0, 5, 10, 10, 5, 0};

    TEST_ASSERT_EQUAL(MODBUS_OK, bench_entry(0, (int16_t)(mark | LINE_START_SMOOTH), 0));
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_entry(0, 5, 10));
    for (uint8_t i = 0; i < 6; i++) {
        TEST_ASSERT_EQUAL(MODBUS_OK, bench_entry(0, counts[i], 1));
    }
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_entry(0, LINE_MARK_END, 0));
}

static bool play_unknown(void)
{
    return (report_status() & REPORT_PLAY) != 0;
}

static void check_play(uint16_t lacking_steps, bool unknown)
{
    TEST_ASSERT_EQUAL_UINT16(lacking_steps, axes_get(0)->line.backlash_steps);
    TEST_ASSERT_EQUAL(unknown, play_unknown());
}

// The second line follows the first in the same direction, so that nothing is lacking then.
static void check_policy(uint16_t policy)
{
    setUp();
    bench_settings()->backlash_policy = policy;
    TEST_ASSERT_FALSE(play_unknown());
    queue_backlash_line(LINE_MARK_START | LINE_START_WAIT);
    queue_backlash_line(LINE_MARK_START);
    arm(1);
    check_play(5, true);
    while (segment_queue_fill(&axes_get(0)->queue) != 0) {
        bench_rounds(1);
    }
    check_play(0, false);
    TEST_ASSERT_TRUE(bench_until(0, AXIS_DONE));
    TEST_ASSERT_EQUAL_UINT16(2, axes_get(0)->lines_done);
    TEST_ASSERT_EQUAL(FAULT_none, faults_record()->code);
}

static void backlash_is_taken_up_where_it_is_lacking(void)
{
    check_policy(0);
    check_policy(1);
}

static void arming_is_all_or_nothing(void)
{
    bench_plain_line(0, 10, 2);
    TEST_ASSERT_EQUAL(MODBUS_DEVICE_FAILURE, bench_command(3, COMMAND_ARM));
    TEST_ASSERT_EQUAL(AXIS_LOADED, axes_get(0)->life.state);
    TEST_ASSERT_EQUAL(MODBUS_DEVICE_FAILURE, bench_command(0, COMMAND_ARM));
    check_nothing_moves();
}

static void refused_line_never_starts(void)
{
    (void)bench_entry(0, LINE_MARK_START | LINE_START_WAIT | LINE_START_SMOOTH, 0);
    (void)bench_entry(0, 0, 0);
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_entry(0, 5, 1));
    TEST_ASSERT_EQUAL(MODBUS_ILLEGAL_VALUE, bench_entry(0, 4, 1));
    TEST_ASSERT_EQUAL(AXIS_REFUSED, axes_get(0)->life.state);
    TEST_ASSERT_EQUAL(LINE_reverses_inside_pixel, axes_get(0)->line_error);
    TEST_ASSERT_EQUAL_UINT32(2, axes_get(0)->line_error_pixel);
    TEST_ASSERT_EQUAL(MODBUS_ILLEGAL_VALUE, bench_entry(0, 5, 1));
    TEST_ASSERT_EQUAL(MODBUS_DEVICE_FAILURE, bench_command(1, COMMAND_ARM));
    check_nothing_moves();
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(1, COMMAND_DISCARD));
    bench_plain_line(0, 7, 2);
    arm(1);
    TEST_ASSERT_TRUE(bench_until(0, AXIS_DONE));
    TEST_ASSERT_EQUAL_INT32(14, fake_axes[0].steps);
}

static void disarmed_line_never_starts(void)
{
    bench_plain_line(0, 10, 2);
    bench_plain_line(1, 10, 2);
    arm(3);
    bench_rounds(1);
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(1, COMMAND_DISARM));
    TEST_ASSERT_EQUAL(AXIS_EMPTY, axes_get(0)->life.state);
    TEST_ASSERT_TRUE(bench_until(1, AXIS_DONE));
    TEST_ASSERT_EQUAL_INT32(0, fake_axes[0].steps);
    TEST_ASSERT_EQUAL_INT32(20, fake_axes[1].steps);
    TEST_ASSERT_EQUAL(FAULT_none, faults_record()->code);
}

static void running_line_is_not_discarded(void)
{
    bench_plain_line(0, 10, 20);
    arm(1);
    TEST_ASSERT_TRUE(bench_until(0, AXIS_RUNNING));
    TEST_ASSERT_EQUAL(MODBUS_DEVICE_FAILURE, bench_command(1, COMMAND_DISCARD));
    TEST_ASSERT_EQUAL(MODBUS_DEVICE_FAILURE, bench_command(1, COMMAND_DISABLE));
    TEST_ASSERT_TRUE(bench_until(0, AXIS_DONE));
    TEST_ASSERT_EQUAL_INT32(200, fake_axes[0].steps);
}

static void stop_stops_one_axis(void)
{
    bench_plain_line(0, 10, 30);
    bench_plain_line(1, 10, 30);
    arm(3);
    TEST_ASSERT_TRUE(bench_until(0, AXIS_RUNNING));
    bench_rounds(100);
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(1, COMMAND_STOP));
    int32_t steps = fake_axes[0].steps;
    TEST_ASSERT_TRUE(bench_until(1, AXIS_DONE));
    TEST_ASSERT_INT32_WITHIN(2, steps, fake_axes[0].steps);
    TEST_ASSERT_TRUE(fake_axes[0].steps > 0 && fake_axes[0].steps < 300);
    TEST_ASSERT_EQUAL_INT32(300, fake_axes[1].steps);
    TEST_ASSERT_EQUAL(FAULT_none, faults_record()->code);
    TEST_ASSERT_EQUAL(AXIS_EMPTY, axes_get(0)->life.state);
    TEST_ASSERT_EQUAL_INT32(fake_axes[0].steps, ledger_position(&axes_get(0)->ledger));
}

static void stopped_axis_runs_the_next_line(void)
{
    bench_plain_line(0, 10, 30);
    arm(1);
    TEST_ASSERT_TRUE(bench_until(0, AXIS_RUNNING));
    bench_rounds(100);
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(1, COMMAND_STOP));
    check_nothing_moves();
    int32_t steps = fake_axes[0].steps;
    bench_plain_line(0, -10, 2);
    arm(1);
    TEST_ASSERT_TRUE(bench_until(0, AXIS_DONE));
    TEST_ASSERT_EQUAL_INT32(steps - 20, fake_axes[0].steps);
    TEST_ASSERT_EQUAL_INT32(steps - 20, ledger_position(&axes_get(0)->ledger));
}

static void stop_forgets_an_armed_line(void)
{
    bench_plain_line(0, 10, 3);
    arm(1);
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(1, COMMAND_STOP));
    check_nothing_moves();
    TEST_ASSERT_EQUAL_INT32(0, fake_axes[0].steps);
    TEST_ASSERT_EQUAL(AXIS_EMPTY, axes_get(0)->life.state);
}

static void drivers_are_enabled_by_mask(void)
{
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(5 & BENCH_ALL_AXES, COMMAND_ENABLE));
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        TEST_ASSERT_EQUAL(i % 2u == 0, fake_axes[i].enabled);
    }
    TEST_ASSERT_EQUAL(MODBUS_OK,
                      bench_command(BENCH_MASK_OF(BENCH_THIRD), COMMAND_DISABLE));
    TEST_ASSERT_FALSE(fake_axes[BENCH_THIRD].enabled);
}

static void streamed_line_longer_than_the_queue(void)
{
    int32_t wanted = bench_long_start(0);
    uint16_t queued = 0;

    arm(1);
    while (queued < 200) {
        if (bench_entry(0, 2, 1) == MODBUS_OK) {
            wanted += 2;
            queued++;
        }
        bench_rounds(2);
    }
    while (bench_entry(0, LINE_MARK_END, 0) != MODBUS_OK) {
        bench_rounds(2);
    }
    TEST_ASSERT_TRUE(bench_until(0, AXIS_DONE));
    TEST_ASSERT_EQUAL_INT32(wanted, fake_axes[0].steps);
    TEST_ASSERT_EQUAL(FAULT_none, faults_record()->code);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(at_rest_after_power_on);
    RUN_TEST(loaded_line_waits_for_arming);
    RUN_TEST(armed_line_runs_to_its_end);
    RUN_TEST(line_after_a_rest_may_go_either_way_at_once);
    RUN_TEST(axes_share_a_zero_on_the_pixel_clock);
    RUN_TEST(start_is_one_period_after_an_edge);
    RUN_TEST(clock_errors_are_zero_on_an_exact_clock);
    RUN_TEST(second_line_waits_for_its_own_arming);
    RUN_TEST(unclocked_line_starts_without_a_clock);
    RUN_TEST(backlash_is_taken_up_where_it_is_lacking);
    RUN_TEST(arming_is_all_or_nothing);
    RUN_TEST(refused_line_never_starts);
    RUN_TEST(disarmed_line_never_starts);
    RUN_TEST(running_line_is_not_discarded);
    RUN_TEST(stop_stops_one_axis);
    RUN_TEST(stopped_axis_runs_the_next_line);
    RUN_TEST(stop_forgets_an_armed_line);
    RUN_TEST(drivers_are_enabled_by_mask);
    RUN_TEST(streamed_line_longer_than_the_queue);
    return UNITY_END();
}
