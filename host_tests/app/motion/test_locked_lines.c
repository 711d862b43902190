// SPDX-License-Identifier: MIT
// The machine with setting `sync` = 2: lines that follow the pixel clock, and what becomes of them
// when the clock misbehaves.
#include <stdbool.h>
#include <stdint.h>

#include "app/registers/report.h"
#include "clock/lock_grid.h"
#include "fakes/board.h"
#include "fakes/board_bench.h"
#include "unity.h"
#include "wire/register_map.h"

#define NOMINAL_TICKS ((uint32_t)BENCH_PIXEL_TICKS)
#define OFF_TICKS     (NOMINAL_TICKS + 80u) // 0.5 % too slow, within the tolerance
#define HOLD_OVER     4u                    // of the default settings
#define SETTLE_ROUNDS 800u

static int16_t pixel_steps; // of every pixel

// The clock's period from its edge at first_ticks on.
static void clock_from(uint32_t first_ticks, uint32_t period_ticks)
{
    fake_pixel_clock(first_ticks, CONFIG_TIMER_HZ, period_ticks);
}

static void open_machine(uint16_t sync, uint16_t divider)
{
    *lock_grid_now() = (struct lock_grid){.locks = false}; // counts from a reset on
    bench_power_on();
    bench_settings()->sync = sync;
    bench_settings()->divider = divider;
    limits_apply_settings();
    clock_from(fake_next_edge_ticks(), OFF_TICKS);
}

void setUp(void)
{
    pixel_steps = 10;
    open_machine(SYNC_LOCK, 1);
}

void tearDown(void)
{
}

// A line of an axis waits for a clock that has settled.
static void arm_line(uint8_t axis, uint16_t pixels)
{
    bench_plain_line(axis, pixel_steps, pixels);
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(BENCH_MASK_OF(axis), COMMAND_ARM));
}

static void run_line(uint8_t axis, uint16_t pixels)
{
    bench_rounds(SETTLE_ROUNDS);
    arm_line(axis, pixels);
    TEST_ASSERT_EQUAL(true, bench_until(axis, AXIS_RUNNING));
    bench_rounds(60);
}

static void check_fault(enum fault code, uint8_t axis)
{
    TEST_ASSERT_EQUAL(true, bench_until(axis, AXIS_FAULT));
    TEST_ASSERT_EQUAL(code, faults_record()->code);
    TEST_ASSERT_EQUAL_UINT8(axis, faults_record()->axis);
}

// The last step of the axis lies on an edge of the clock, so many edges behind line zero.
static void check_done(uint8_t axis, uint16_t pixels, uint16_t edges)
{
    TEST_ASSERT_EQUAL(true, bench_until(axis, AXIS_DONE));
    TEST_ASSERT_EQUAL(FAULT_none, faults_record()->code);
    TEST_ASSERT_EQUAL_INT32(pixel_steps * (int32_t)pixels, fake_axes[axis].steps);
    TEST_ASSERT_UINT32_WITHIN(2,
                              axes_get(axis)->zero_ticks + edges * OFF_TICKS,
                              fake_axes[axis].last_step_ticks);
}

// An instant, seen from the clock's next edge, lies on an edge; the clock has not changed since.
static void check_on_an_edge(uint32_t ticks)
{
    uint32_t behind = fake_next_edge_ticks() + 1000u * OFF_TICKS - ticks;

    TEST_ASSERT_UINT32_WITHIN(2, 2, (behind + 2u) % OFF_TICKS);
}

static void lines_wait_for_a_clock_that_has_settled(void)
{
    bench_plain_line(0, pixel_steps, 3);
    bench_rounds(50);
    TEST_ASSERT_EQUAL_HEX16(REPORT_CLOCK, report_status());
    TEST_ASSERT_NOT_EQUAL(MODBUS_OK, bench_command(1, COMMAND_ARM));
    bench_rounds(SETTLE_ROUNDS);
    TEST_ASSERT_EQUAL_HEX16(REPORT_CLOCK | REPORT_SETTLED, report_status());
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(1, COMMAND_ARM));
    check_done(0, 3, 3);
}

// The period is known for as long as a clock rests; its first edge after that gives the phase, and
// line zero is counted from there.
static void a_line_waits_for_a_clock_that_rests(void)
{
    bench_rounds(SETTLE_ROUNDS);
    bench_plain_line(0, pixel_steps, 20);
    TEST_ASSERT_EQUAL(true, bench_give(1, COMMAND_ARM, 7)); // waits for a token, too
    bench_clock_off();
    bench_rounds(2000);
    TEST_ASSERT_EQUAL_HEX16(REPORT_SETTLED | REPORT_ARMED, report_status());
    TEST_ASSERT_EQUAL_UINT16(1, bench_input(REG_INPUT_ready));
    TEST_ASSERT_EQUAL_UINT16(0, bench_input(REG_INPUT_mark_steady));
    TEST_ASSERT_EQUAL(true, bench_give(0, COMMAND_MARK, 0));
    bench_rounds(1);
    TEST_ASSERT_EQUAL_UINT16(1, bench_input(REG_INPUT_mark_steady));
    TEST_ASSERT_EQUAL(true, bench_give(0, COMMAND_GO, 7));
    bench_rounds(2000);
    TEST_ASSERT_EQUAL_HEX16(REPORT_SETTLED | REPORT_ARMED, report_status());
    uint32_t first_ticks = fake_now_ticks() + 5000u;
    clock_from(first_ticks, OFF_TICKS);
    check_done(0, 20, 20);
    TEST_ASSERT_UINT32_WITHIN(
        2, first_ticks + (BENCH_GO_EDGES - 1u) * OFF_TICKS, axes_get(0)->zero_ticks);
}

static void all_axes_run_on_the_clocks_edges(void)
{
    bench_rounds(SETTLE_ROUNDS);
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        bench_plain_line(i, pixel_steps, (uint16_t)(20u + i));
    }
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(BENCH_ALL_AXES, COMMAND_ARM));
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        check_done(i, (uint16_t)(20u + i), (uint16_t)(20u + i));
        check_on_an_edge(axes_get(i)->zero_ticks);
    }
}

// Every third edge of the clock is a pixel's.
// Pixels of so many even steps are pulse trains: the decoder comes up to the edge that is not known
// yet, and goes on behind it.
static void pixels_of_many_steps_are_locked_too(void)
{
    pixel_steps = 70;
    run_line(0, 60);
    check_done(0, 60, 60);
    check_on_an_edge(fake_axes[0].last_step_ticks);
}

static void a_pixel_has_as_many_edges_as_the_divider(void)
{
    open_machine(SYNC_LOCK, 3);
    bench_rounds(SETTLE_ROUNDS);
    arm_line(0, 25);
    check_done(0, 25, 75);
    check_on_an_edge(axes_get(0)->zero_ticks);
}

// The second line begins on a pixel edge of the first one, not on any edge of the clock.
static void a_line_beside_a_running_one_shares_its_pixel_edges(void)
{
    open_machine(SYNC_LOCK, 3);
    run_line(BENCH_LAST, 40);
    bench_rounds(101);
    arm_line(0, 15);
    check_done(0, 15, 45);
    uint32_t apart = axes_get(0)->zero_ticks - axes_get(BENCH_LAST)->zero_ticks;
    TEST_ASSERT_UINT32_WITHIN(2, 2, (apart + 2u) % (3u * OFF_TICKS));
    check_done(BENCH_LAST, 40, 120);
}

static void missing_edges_are_bridged(void)
{
    run_line(0, 60);
    clock_from(fake_next_edge_ticks() + HOLD_OVER * OFF_TICKS, OFF_TICKS);
    check_done(0, 60, 60);
    TEST_ASSERT_EQUAL_UINT16(HOLD_OVER, lock_grid_now()->filter.missing);
}

// A command that discards the lines of the clock's axis waits for an edge that must be placed by
// that axis's account.
static void an_edge_is_placed_before_the_lines_of_its_axis_are_discarded(void)
{
#if CONFIG_AXES > 1
    uint16_t missing = 0;

    run_line(0, 40);
    missing = lock_grid_now()->filter.missing;
    fake_pass(fake_next_edge_ticks() + 5000u - fake_now_ticks());
    TEST_ASSERT_EQUAL(
        MODBUS_OK,
        bench_command(BENCH_MASK_OF(CONFIG_PIXEL_CLOCK_AXIS), COMMAND_DISCARD));
    TEST_ASSERT_EQUAL(true, bench_until(0, AXIS_DONE));
    TEST_ASSERT_EQUAL_UINT16(missing, lock_grid_now()->filter.missing);
    check_done(0, 40, 40);
#endif
}

static void a_clock_that_stays_away_is_a_fault(void)
{
    run_line(0, 60);
    bench_clock_off();
    check_fault(FAULT_clock_hold_over, 0);
    TEST_ASSERT_EQUAL_UINT16(HOLD_OVER, faults_record()->argument);
    TEST_ASSERT_FALSE(reference_present());
}

static void a_clock_that_leaves_the_tolerance_is_a_fault(void)
{
    run_line(0, 400);
    clock_from(fake_next_edge_ticks(), NOMINAL_TICKS + 200u);
    check_fault(FAULT_clock_drifted, 0);
    TEST_ASSERT_EQUAL_UINT16((NOMINAL_TICKS + 161u) >> 8, faults_record()->argument);
}

// The same clock is nobody's fault while no line follows it.
static void a_drifting_clock_without_lines_is_no_fault(void)
{
    clock_from(fake_next_edge_ticks(), NOMINAL_TICKS + 200u);
    bench_rounds(SETTLE_ROUNDS);
    TEST_ASSERT_EQUAL(FAULT_none, faults_record()->code);
    TEST_ASSERT_TRUE(reference_settled());
}

// One edge where none can be, alone between two others.
static void a_glitch_changes_nothing(void)
{
    run_line(0, 60);
    // Early between two edges, so that the false one is still to come.
    while (fake_next_edge_ticks() - fake_now_ticks() < OFF_TICKS / 4u * 3u) {
        bench_rounds(1);
    }
    uint32_t next = fake_next_edge_ticks();

    clock_from(next - OFF_TICKS / 2u, OFF_TICKS);
    while (fake_next_edge_ticks() == next - OFF_TICKS / 2u) {
        bench_rounds(1);
    }
    clock_from(next, OFF_TICKS);
    check_done(0, 60, 60);
    TEST_ASSERT_EQUAL_UINT16(1, lock_grid_now()->filter.glitches);
}

static void crowded_edges_are_glitches_of_a_locked_clock(void)
{
    run_line(0, 60);
    fake_crowded_edge();
    check_done(0, 60, 60);
    TEST_ASSERT_EQUAL_UINT16(1, lock_grid_now()->filter.glitches);
}

static void crowded_edges_are_lost_by_lines_that_are_not_locked(void)
{
    open_machine(SYNC_START, 1);
    run_line(0, 60);
    fake_crowded_edge();
    check_fault(FAULT_clock_edge_lost, 0);
    TEST_ASSERT_EQUAL_UINT16(1, faults_record()->argument);
}

// Without the clock axis's interrupt no edge can be placed: this is what is said, not that the
// clock is missing.
static void a_clock_that_cannot_be_placed_is_an_underrun(void)
{
    run_line(0, 60);
    fake_hang_axis(CONFIG_PIXEL_CLOCK_AXIS);
    bench_clock_off();
    TEST_ASSERT_EQUAL(true, bench_until(0, AXIS_FAULT));
    TEST_ASSERT_EQUAL(FAULT_underrun, faults_record()->code);
    TEST_ASSERT_EQUAL_UINT8(CONFIG_PIXEL_CLOCK_AXIS, faults_record()->axis);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(lines_wait_for_a_clock_that_has_settled);
    RUN_TEST(a_line_waits_for_a_clock_that_rests);
    RUN_TEST(all_axes_run_on_the_clocks_edges);
    RUN_TEST(pixels_of_many_steps_are_locked_too);
    RUN_TEST(a_pixel_has_as_many_edges_as_the_divider);
    RUN_TEST(a_line_beside_a_running_one_shares_its_pixel_edges);
    RUN_TEST(missing_edges_are_bridged);
    RUN_TEST(an_edge_is_placed_before_the_lines_of_its_axis_are_discarded);
    RUN_TEST(a_clock_that_stays_away_is_a_fault);
    RUN_TEST(a_clock_that_leaves_the_tolerance_is_a_fault);
    RUN_TEST(a_drifting_clock_without_lines_is_no_fault);
    RUN_TEST(a_glitch_changes_nothing);
    RUN_TEST(crowded_edges_are_glitches_of_a_locked_clock);
    RUN_TEST(crowded_edges_are_lost_by_lines_that_are_not_locked);
    RUN_TEST(a_clock_that_cannot_be_placed_is_an_underrun);
    return UNITY_END();
}
