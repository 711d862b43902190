// SPDX-License-Identifier: MIT
// The machine on a gated pixel clock: bursts of edges with rests between them, a line for each.
#include <stdbool.h>
#include <stdint.h>

#include "app/axes/gate.h"
#include "app/axes/mark.h"
#include "app/motion/clock_edges.h"
#include "clock/lock_grid.h"
#include "fakes/board.h"
#include "fakes/board_bench.h"
#include "unity.h"
#include "wire/register_map.h"

#if FEATURE_GATE

#define PERIOD_TICKS  ((uint32_t)BENCH_PIXEL_TICKS)
#define GATE_EDGES    12u // six edges lie ahead of line zero when a line gets its place
#define PIXELS        20u
#define BURST_EDGES   (GATE_EDGES + PIXELS + 1u)
#define STEPS         10
#define REST_TICKS    300000uL
#define SETTLE_ROUNDS 800u

static uint32_t first_ticks; // the first edge of the newest burst

static void open_machine(uint16_t sync, uint16_t gate_edges)
{
    *lock_grid_now() = (struct lock_grid){.locks = false};
    bench_power_on();
    bench_settings()->sync = sync;
    bench_settings()->gate_edges = gate_edges;
    bench_settings()->bus_timeout_ms = 0;
    limits_apply_settings();
    bench_rounds(SETTLE_ROUNDS);
    bench_clock_off();
    bench_rounds(100);
}

void setUp(void)
{
    open_machine(SYNC_START, GATE_EDGES);
}

void tearDown(void)
{
}

static void pass(uint32_t ticks)
{
    uint32_t end_ticks = fake_now_ticks() + ticks;

    while ((int32_t)(end_ticks - fake_now_ticks()) > 0) {
        bench_rounds(1);
    }
}

static void clock_runs(uint32_t from_ticks)
{
    fake_pixel_clock(from_ticks, CONFIG_TIMER_HZ, PERIOD_TICKS);
}

// So many edges, the first one in a moment; time passes to the middle behind the last one.
static void burst(uint16_t edges)
{
    first_ticks = fake_now_ticks() + 5000u;
    clock_runs(first_ticks);
    pass(5000u + (uint32_t)edges * PERIOD_TICKS - PERIOD_TICKS / 2u);
    bench_clock_off();
}

static void rest(void)
{
    pass(REST_TICKS);
}

static void arm(uint16_t mask)
{
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(mask, COMMAND_ARM));
}

static void arm_line(uint8_t axis)
{
    bench_plain_line(axis, STEPS, PIXELS);
    arm(BENCH_MASK_OF(axis));
}

static void check_state(uint8_t axis, enum axis_state state)
{
    TEST_ASSERT_EQUAL(FAULT_none, faults_record()->code);
    TEST_ASSERT_EQUAL_UINT8(state, axes_get(axis)->life.state);
}

// So many lines of the axis were made; the last step of the newest is on its edge of its burst.
static void check_made(uint8_t axis, uint16_t lines)
{
    TEST_ASSERT_EQUAL(FAULT_none, faults_record()->code);
    TEST_ASSERT_EQUAL_UINT16(lines, axes_get(axis)->lines_done);
    TEST_ASSERT_EQUAL_INT32((int32_t)lines * STEPS * (int32_t)PIXELS,
                            fake_axes[axis].steps);
    TEST_ASSERT_UINT32_WITHIN(2,
                              first_ticks +
                                  (uint32_t)(GATE_EDGES + PIXELS) * PERIOD_TICKS,
                              fake_axes[axis].last_step_ticks);
}

static void check_fault(enum fault code)
{
    TEST_ASSERT_EQUAL(code, faults_record()->code);
}

static void a_line_waits_for_a_burst(void)
{
    arm_line(0);
    bench_rounds(4000);
    check_state(0, AXIS_ARMED);
    burst(BURST_EDGES);
    rest();
    check_made(0, 1);
    check_state(0, AXIS_DONE);
}

static void a_line_armed_inside_a_burst_waits_for_the_next(void)
{
    burst(BURST_EDGES / 2u);
    clock_runs(first_ticks + BURST_EDGES / 2u * PERIOD_TICKS);
    arm_line(0);
    pass(BURST_EDGES / 2u * PERIOD_TICKS);
    bench_clock_off();
    rest();
    check_state(0, AXIS_ARMED);
    burst(BURST_EDGES);
    rest();
    check_made(0, 1);
}

static void lines_follow_each_other_over_the_rests(uint16_t sync)
{
    open_machine(sync, GATE_EDGES);
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        for (uint8_t line = 0; line < 3; line++) {
            bench_plain_line(i, STEPS, PIXELS);
        }
    }
    arm(BENCH_ALL_AXES);
    for (uint16_t lines = 1; lines <= 3; lines++) {
        burst(BURST_EDGES);
        rest();
        for (uint8_t i = 0; i < CONFIG_AXES; i++) {
            check_made(i, lines);
            check_state(i, lines == 3 ? AXIS_DONE : AXIS_ARMED);
        }
    }
}

static void started_lines_follow_each_other(void)
{
    lines_follow_each_other_over_the_rests(SYNC_START);
}

static void locked_lines_follow_each_other(void)
{
    lines_follow_each_other_over_the_rests(SYNC_LOCK);
}

// Edges behind a line's last one belong to no line.
static void a_burst_may_last_longer(void)
{
    bench_plain_line(0, STEPS, PIXELS);
    arm_line(0);
    burst(BURST_EDGES + 15u);
    check_made(0, 1);
    rest();
    check_state(0, AXIS_ARMED);
    burst(BURST_EDGES);
    rest();
    check_made(0, 2);
}

// The rest is a sixteenth of the period longer than nothing, and a little.
static void a_short_rest_is_one(void)
{
    bench_plain_line(0, STEPS, PIXELS);
    arm_line(0);
    burst(BURST_EDGES);
    first_ticks += BURST_EDGES * PERIOD_TICKS + PERIOD_TICKS / 16u + 50u;
    clock_runs(first_ticks);
    pass((BURST_EDGES + 1u) * PERIOD_TICKS);
    bench_clock_off();
    rest();
    check_made(0, 2);
}

static void a_burst_too_short(uint16_t sync, uint16_t edges, enum fault code)
{
    open_machine(sync, GATE_EDGES);
    bench_plain_line(0, STEPS, PIXELS);
    arm_line(0);
    burst(edges);
    rest();
    check_fault(code);
}

static void bursts_that_are_too_short_are_faults(void)
{
    a_burst_too_short(SYNC_START, 1, FAULT_pixel_clock_missing);
    a_burst_too_short(SYNC_START, GATE_EDGES - 3u, FAULT_pixel_clock_missing);
    a_burst_too_short(SYNC_START, BURST_EDGES - 5u, FAULT_pixel_clock_missing);
    a_burst_too_short(SYNC_START, BURST_EDGES - 1u, FAULT_pixel_clock_missing);
    a_burst_too_short(SYNC_LOCK, 1, FAULT_clock_hold_over);
    a_burst_too_short(SYNC_LOCK, BURST_EDGES - 8u, FAULT_clock_hold_over);
    a_burst_too_short(SYNC_LOCK, BURST_EDGES - 3u, FAULT_pixel_clock_missing);
    a_burst_too_short(SYNC_LOCK, BURST_EDGES - 1u, FAULT_pixel_clock_missing);
}

// A false edge in a rest is taken for a burst's first edge. The second edge comes too early.
static void a_false_edge(uint16_t sync, uint32_t before_ticks)
{
    open_machine(sync, GATE_EDGES);
    arm_line(0);
    fake_pixel_clock(fake_now_ticks() + 5000u, CONFIG_TIMER_HZ, before_ticks);
    pass(5000u + before_ticks / 2u);
    first_ticks = fake_next_edge_ticks();
    clock_runs(first_ticks);
    pass(BURST_EDGES * PERIOD_TICKS);
    check_fault(FAULT_pixel_clock_off);
    TEST_ASSERT_EQUAL_INT32(0, fake_axes[0].steps);
}

static void a_false_edge_before_a_burst_is_a_fault(void)
{
    a_false_edge(SYNC_START, PERIOD_TICKS / 2u);
    a_false_edge(SYNC_START, PERIOD_TICKS / 8u * 9u);
    a_false_edge(SYNC_LOCK, PERIOD_TICKS / 2u);
    a_false_edge(SYNC_LOCK, PERIOD_TICKS / 8u * 9u);
}

// Between its neighbours no distance is longer than a period: the rest cannot be seen.
static void a_false_edge_in_a_short_rest(uint16_t sync)
{
    open_machine(sync, GATE_EDGES);
    bench_plain_line(0, STEPS, PIXELS);
    arm_line(0);
    burst(BURST_EDGES);
    uint32_t last_ticks = first_ticks + (BURST_EDGES - 1u) * PERIOD_TICKS;
    clock_runs(last_ticks + PERIOD_TICKS / 4u * 3u);
    pass(PERIOD_TICKS / 2u);
    clock_runs(last_ticks + PERIOD_TICKS / 2u * 3u);
    pass(BURST_EDGES * PERIOD_TICKS);
    check_fault(FAULT_pixel_clock_off);
    TEST_ASSERT_EQUAL_INT32(STEPS * (int32_t)PIXELS, fake_axes[0].steps);
}

static void a_false_edge_that_hides_a_rest_is_a_fault(void)
{
    a_false_edge_in_a_short_rest(SYNC_START);
    a_false_edge_in_a_short_rest(SYNC_LOCK);
}

// Two edges so close to each other are none: the next one cannot be told from the first.
static void a_first_edge_that_is_not_captured(uint16_t sync)
{
    open_machine(sync, GATE_EDGES);
    arm_line(0);
    bench_rounds(200);
    fake_crowded_edge();
    burst(BURST_EDGES);
    check_fault(FAULT_clock_edge_lost);
    TEST_ASSERT_EQUAL_INT32(0, fake_axes[0].steps);
}

static void a_first_edge_that_is_not_captured_is_a_fault(void)
{
    a_first_edge_that_is_not_captured(SYNC_START);
    a_first_edge_that_is_not_captured(SYNC_LOCK);
}

static void an_edge_missing_before_line_zero_is_a_fault(void)
{
    arm_line(0);
    burst(3);
    first_ticks += 4u * PERIOD_TICKS;
    clock_runs(first_ticks);
    pass(BURST_EDGES * PERIOD_TICKS);
    check_fault(FAULT_pixel_clock_missing);
    TEST_ASSERT_EQUAL_INT32(0, fake_axes[0].steps);
}

// It cannot be seen where it is missing; the burst ends an edge before the line.
static void a_first_edge_that_is_missing_is_a_fault_at_the_end(void)
{
    arm_line(0);
    burst(BURST_EDGES - 1u);
    rest();
    check_fault(FAULT_pixel_clock_missing);
}

static void a_missing_edge_between_lines_is_none(void)
{
    burst(40);
    clock_runs(first_ticks + 42u * PERIOD_TICKS);
    pass(10u * PERIOD_TICKS);
    TEST_ASSERT_EQUAL(FAULT_none, faults_record()->code);
}

static void line_zero_must_be_far_enough(uint16_t sync, uint16_t least)
{
    open_machine(sync, (uint16_t)(least - 1u));
    bench_plain_line(0, STEPS, PIXELS);
    TEST_ASSERT_NOT_EQUAL(MODBUS_OK, bench_command(1, COMMAND_ARM));
    check_state(0, AXIS_LOADED);
    open_machine(sync, least);
    bench_plain_line(0, STEPS, PIXELS);
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(1, COMMAND_ARM));
}

static void a_line_zero_too_near_is_refused(void)
{
    line_zero_must_be_far_enough(SYNC_START, reference_place_edges());
    line_zero_must_be_far_enough(
        SYNC_LOCK, (uint16_t)(reference_place_edges() + CLOCK_FILTER_FRESH_EDGES));
}

// The main loop is held up from a line's end until the next burst has begun: the next line cannot
// be armed in time.
static void a_line_that_comes_too_late_is_a_fault(void)
{
    uint16_t edges = (uint16_t)(reference_place_edges() + PIXELS);

    open_machine(SYNC_START, reference_place_edges());
    bench_plain_line(0, STEPS, PIXELS);
    arm_line(0);
    bench_rounds(200);
    burst(edges);
    clock_runs(first_ticks + edges * PERIOD_TICKS);
    fake_pass(PERIOD_TICKS);
    clock_runs(first_ticks + edges * PERIOD_TICKS + 2u * PERIOD_TICKS);
    TEST_ASSERT_EQUAL_UINT8(AXIS_RUNNING, axes_get(0)->life.state);
    fake_pass(7u * PERIOD_TICKS + PERIOD_TICKS / 2u);
    bench_rounds(5000);
    bench_clock_off();
    check_fault(FAULT_start_late);
    TEST_ASSERT_EQUAL_INT32(STEPS * (int32_t)PIXELS, fake_axes[0].steps);
}

// Lines that wait for a token wait over the bursts; the edge that `go` names may be in any of them.
static void a_token_waits_over_bursts(void)
{
    bench_plain_line(0, STEPS, PIXELS);
    TEST_ASSERT_EQUAL(true, bench_give(1, COMMAND_ARM, 7));
    burst(BURST_EDGES);
    rest();
    check_state(0, AXIS_ARMED);
    TEST_ASSERT_EQUAL(true, bench_give(0, COMMAND_MARK, 0));
    bench_rounds(1);
    const struct order go = {0, COMMAND_GO, 7, bench_edge_ahead(1u + GATE_EDGES)};
    TEST_ASSERT_EQUAL(true, commands_give(&go));
    rest();
    check_state(0, AXIS_ARMED);
    burst(BURST_EDGES);
    rest();
    check_made(0, 1);
}

static void a_token_goes_in_a_later_burst(void)
{
    bench_plain_line(0, STEPS, PIXELS);
    TEST_ASSERT_EQUAL(true, bench_give(1, COMMAND_ARM, 7));
    bench_rounds(200);
    TEST_ASSERT_EQUAL(true, bench_give(0, COMMAND_MARK, 0));
    bench_rounds(1);
    const struct order go = {
        0, COMMAND_GO, 7, bench_edge_ahead(BURST_EDGES + 1u + GATE_EDGES)};
    TEST_ASSERT_EQUAL(true, commands_give(&go));
    burst(BURST_EDGES);
    rest();
    check_state(0, AXIS_ARMED);
    burst(BURST_EDGES);
    rest();
    check_made(0, 1);
}

// Several axes are armed at once: nobody joins those that wait for the edge that a burst has named.
static void nobody_joins_a_burst(void)
{
#if CONFIG_AXES > 1
    arm_line(0);
    bench_plain_line(BENCH_LAST, STEPS, PIXELS);
    burst(3);
    clock_runs(first_ticks + 3u * PERIOD_TICKS);
    TEST_ASSERT_NOT_EQUAL(MODBUS_OK,
                          bench_command(BENCH_MASK_OF(BENCH_LAST), COMMAND_ARM));
    pass((BURST_EDGES - 3u) * PERIOD_TICKS);
    bench_clock_off();
    rest();
    check_made(0, 1);
#endif
}

// The main loop finds a line that is over and the first edge of the next burst at once: the edge
// that the burst names is for the lines that the board will arm, and no command may take it away.
static void no_command_takes_the_edge_that_a_burst_has_named(void)
{
#if CONFIG_AXES > 1
    bench_plain_line(0, STEPS, PIXELS);
    arm_line(0);
    bench_plain_line(BENCH_LAST, STEPS, PIXELS);
    burst(BURST_EDGES - 1u);
    first_ticks += (BURST_EDGES - 1u) * PERIOD_TICKS;
    clock_runs(first_ticks);
    fake_pass(PERIOD_TICKS);
    first_ticks += PERIOD_TICKS + PERIOD_TICKS / 2u;
    clock_runs(first_ticks);
    fake_pass(PERIOD_TICKS + PERIOD_TICKS / 2u);
    clock_edges_poll();
    TEST_ASSERT_TRUE(token_edge_by_gate());
    TEST_ASSERT_EQUAL_UINT8(AXIS_RUNNING, axes_get(0)->life.state);
    TEST_ASSERT_NOT_EQUAL(MODBUS_OK,
                          bench_command(BENCH_MASK_OF(BENCH_LAST), COMMAND_ARM));
    TEST_ASSERT_TRUE(token_edge_by_gate());
    pass((BURST_EDGES - 1u) * PERIOD_TICKS);
    bench_clock_off();
    rest();
    check_made(0, 2);
#endif
}

// A line that was queued behind another one and is not whole is the host's to arm.
static void a_line_that_is_not_whole_is_not_armed(void)
{
    arm_line(0);
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_entry(0, LINE_MARK_START | LINE_START_WAIT, 0));
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_entry(0, 0, 0));
    burst(BURST_EDGES);
    rest();
    check_state(0, AXIS_LOADING);
}

static void a_clock_without_a_gate_is_as_ever(void)
{
    open_machine(SYNC_START, 0);
    arm_line(0);
    bench_rounds(4000);
    check_fault(FAULT_pixel_clock_missing);
}

static void a_gate_that_is_set_again_knows_of_no_rest(void)
{
    bench_rounds(100);
    bench_settings()->gate_edges = 0;
    limits_apply_settings();
    burst(50);
    clock_runs(first_ticks + 50u * PERIOD_TICKS);
    bench_settings()->gate_edges = GATE_EDGES;
    limits_apply_settings();
    arm_line(0);
    pass(50u * PERIOD_TICKS);
    check_state(0, AXIS_ARMED);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_line_waits_for_a_burst);
    RUN_TEST(a_line_armed_inside_a_burst_waits_for_the_next);
    RUN_TEST(started_lines_follow_each_other);
    RUN_TEST(locked_lines_follow_each_other);
    RUN_TEST(a_burst_may_last_longer);
    RUN_TEST(a_short_rest_is_one);
    RUN_TEST(bursts_that_are_too_short_are_faults);
    RUN_TEST(a_false_edge_before_a_burst_is_a_fault);
    RUN_TEST(a_false_edge_that_hides_a_rest_is_a_fault);
    RUN_TEST(a_first_edge_that_is_not_captured_is_a_fault);
    RUN_TEST(an_edge_missing_before_line_zero_is_a_fault);
    RUN_TEST(a_first_edge_that_is_missing_is_a_fault_at_the_end);
    RUN_TEST(a_missing_edge_between_lines_is_none);
    RUN_TEST(a_line_zero_too_near_is_refused);
    RUN_TEST(a_line_that_comes_too_late_is_a_fault);
    RUN_TEST(a_token_waits_over_bursts);
    RUN_TEST(a_token_goes_in_a_later_burst);
    RUN_TEST(nobody_joins_a_burst);
    RUN_TEST(no_command_takes_the_edge_that_a_burst_has_named);
    RUN_TEST(a_line_that_is_not_whole_is_not_armed);
    RUN_TEST(a_clock_without_a_gate_is_as_ever);
    RUN_TEST(a_gate_that_is_set_again_knows_of_no_rest);
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
