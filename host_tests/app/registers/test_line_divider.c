// SPDX-License-Identifier: MIT
// Lines that say how many clock edges a pixel has, through the register map of a whole board: what
// that is to setting `divider`, and when it may change.
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#include "app/settings/store.h"
#include "fakes/board.h"
#include "fakes/board_bench.h"
#include "unity.h"
#include "wire/bytes.h"
#include "wire/register_map.h"

#define START        ((uint16_t)(LINE_MARK_START | LINE_START_WAIT | LINE_START_DIVIDER))
#define UNCLOCKED    ((uint16_t)(LINE_MARK_START | LINE_START_DIVIDER))
#define CLOCK_TICKS  ((uint32_t)BENCH_PIXEL_TICKS)
#define MOST_ENTRIES 12u

static int16_t fast; // steps: too many for a pixel of one edge, but not for one of two

void setUp(void)
{
    bench_power_on();
    fast = (int16_t)(BENCH_PIXEL_TICKS * 3uL / 2u / limits_of(0)->min_interval_ticks);
}

void tearDown(void)
{
    TEST_ASSERT_TRUE(settings_are_possible());
    TEST_ASSERT_EQUAL_UINT32(CLOCK_TICKS * settings_now()->divider,
                             bench_input_wide(REG_INPUT_pixel_period_ticks));
}

// Queue entries as one block.
static enum modbus_exception block(uint8_t axis,
                                   const struct segment *entries,
                                   uint8_t count)
{
    uint8_t words[4u + 4u * MOST_ENTRIES];

    put_word(&words[0], axes_get(axis)->next_block);
    put_word(&words[2], axis);
    for (uint8_t i = 0; i < count; i++) {
        put_word(&words[4u + 4u * i], (uint16_t)entries[i].count);
        put_word(&words[6u + 4u * i], entries[i].repeat);
    }
    return data_write(REG_QUEUE_WINDOW, (uint16_t)(2u + 2u * count), words);
}

#define BLOCK(axis, ...)                                                                 \
    block((axis),                                                                        \
          (const struct segment[]){__VA_ARGS__},                                         \
          sizeof((const struct segment[]){__VA_ARGS__}) / sizeof(struct segment))

#define HEAD(edges) {(int16_t)START, 0}, {0, 0}, {(int16_t)(edges), 0}
#define END         {LINE_MARK_END, 0}

static enum modbus_exception line(uint8_t axis, uint16_t edges, int16_t count)
{
    return BLOCK(axis, HEAD(edges), {count, 3}, END);
}

static enum modbus_exception write_setting(uint16_t address, uint16_t value)
{
    uint8_t words[2];

    put_word(words, value);
    return data_write(address, 1, words);
}

static void check_edges(uint16_t edges)
{
    TEST_ASSERT_EQUAL_UINT16(edges, data_holding(REG_HOLDING_divider));
}

static void check_refused(uint8_t axis, uint16_t edges)
{
    const struct axis *refused = axes_get(axis);

    TEST_ASSERT_EQUAL(LINE_divider, refused->line_error);
    TEST_ASSERT_EQUAL_UINT32(1, refused->line_error_pixel);
    check_edges(edges);
}

static void discard(uint8_t axis)
{
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(BENCH_MASK_OF(axis), COMMAND_DISCARD));
    bench_rounds(20);
    TEST_ASSERT_EQUAL(AXIS_EMPTY, axes_get(axis)->life.state);
}

static void first_segment_has_the_lines_pixels(void)
{
    TEST_ASSERT_EQUAL(MODBUS_ILLEGAL_VALUE, line(0, 1, fast));
    TEST_ASSERT_EQUAL(LINE_too_fast, axes_get(0)->line_error);
    discard(0);
    TEST_ASSERT_EQUAL(MODBUS_OK, line(0, 2, fast));
    TEST_ASSERT_EQUAL(AXIS_LOADED, axes_get(0)->life.state);
    check_edges(2);
    discard(0);
    // And the other way round.
    TEST_ASSERT_EQUAL(MODBUS_ILLEGAL_VALUE, line(0, 1, fast));
    TEST_ASSERT_EQUAL(LINE_too_fast, axes_get(0)->line_error);
    TEST_ASSERT_EQUAL_UINT32(1, axes_get(0)->line_error_pixel);
}

static void line_runs_by_its_pixels(void)
{
    TEST_ASSERT_EQUAL(MODBUS_OK, line(0, 5, 20));
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(1, COMMAND_ARM));
    TEST_ASSERT_TRUE(bench_until(0, AXIS_RUNNING));
    const uint32_t step_ticks = 5u * CLOCK_TICKS / 20u;
    for (int32_t ticks = 0; ticks < 60 * (int32_t)step_ticks;) {
        bench_rounds(1);
        ticks = (int32_t)(fake_now_ticks() - axes_get(0)->zero_ticks);
        (void)axes_advance(0, LEDGER_EXACTLY);
        int32_t steps = ledger_position(&axes_get(0)->ledger);
        TEST_ASSERT_INT32_WITHIN(
            step_ticks, ticks < 0 ? 0 : ticks, steps * (int32_t)step_ticks);
    }
    TEST_ASSERT_TRUE(bench_until(0, AXIS_DONE));
    TEST_ASSERT_EQUAL_INT32(60, ledger_position(&axes_get(0)->ledger));
    TEST_ASSERT_EQUAL_UINT32(3, axes_get(0)->ledger.pixel);
}

// Of the second line only the head is there when the first one ends.
static void head_stays_when_the_line_before_ends(void)
{
    for (uint8_t entries = 1; entries <= 2; entries++) {
        const struct segment head[] = {HEAD(3)};

        bench_power_on();
        TEST_ASSERT_EQUAL(MODBUS_OK, line(0, 2, 5));
        TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(1, COMMAND_ARM));
        TEST_ASSERT_TRUE(bench_until(0, AXIS_RUNNING));
        TEST_ASSERT_EQUAL(MODBUS_OK, block(0, head, entries));
        TEST_ASSERT_TRUE(bench_until(0, AXIS_LOADING));
        TEST_ASSERT_EQUAL(MODBUS_OK, block(0, &head[entries], (uint8_t)(3u - entries)));
        check_edges(3);
    }
}

// And here the whole second line is, and the head of a third.
static void head_behind_a_line_stays_behind_it(void)
{
    bench_power_on();
    TEST_ASSERT_EQUAL(MODBUS_OK, line(0, 2, 5));
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(1, COMMAND_ARM));
    TEST_ASSERT_TRUE(bench_until(0, AXIS_RUNNING));
    TEST_ASSERT_EQUAL(MODBUS_OK, line(0, 2, 5));
    TEST_ASSERT_EQUAL(MODBUS_OK, BLOCK(0, {(int16_t)START, 0}, {0, 0}));
    TEST_ASSERT_TRUE(bench_until(0, AXIS_LOADED));
    TEST_ASSERT_EQUAL(MODBUS_ILLEGAL_VALUE, BLOCK(0, {3, 0}));
    check_refused(0, 2);
}

// Entry by entry, and in two blocks at every place.
static void pieces_of_any_size(void)
{
    const struct segment entries[] = {HEAD(2), {fast, 3}, {-4, 2}, END};
    const uint8_t count = sizeof entries / sizeof entries[0];

    for (uint8_t first = 1; first < count; first++) {
        bench_power_on();
        TEST_ASSERT_EQUAL(MODBUS_OK, block(0, entries, first));
        check_edges(first < 3 ? 1 : 2);
        TEST_ASSERT_EQUAL(MODBUS_OK, block(0, &entries[first], (uint8_t)(count - first)));
        TEST_ASSERT_EQUAL(AXIS_LOADED, axes_get(0)->life.state);
        check_edges(2);
    }
    bench_power_on();
    for (uint8_t i = 0; i < count; i++) {
        TEST_ASSERT_EQUAL(MODBUS_OK, block(0, &entries[i], 1));
    }
    TEST_ASSERT_EQUAL(AXIS_LOADED, axes_get(0)->life.state);
}

static void check_impossible(uint16_t edges)
{
    bench_power_on();
    TEST_ASSERT_EQUAL(MODBUS_ILLEGAL_VALUE, line(0, edges, 5));
    TEST_ASSERT_EQUAL(AXIS_REFUSED, axes_get(0)->life.state);
    check_refused(0, 1);
    TEST_ASSERT_EQUAL_UINT16(0, segment_queue_fill(&axes_get(0)->queue));
}

static void range_of_the_setting(void)
{
    check_impossible(0);
    check_impossible(1001);
    check_impossible(0x8001);
    check_impossible(65535);
    bench_power_on();
    TEST_ASSERT_EQUAL(MODBUS_OK, line(0, 1000, 5));
    check_edges(1000);
}

// At the bench's clock 1000 edges are 16,000,000 ticks, and a pixel that is locked must leave a
// sixteenth of the longest one free.
static void pixel_that_cannot_be(void)
{
    bench_settings()->sync = SYNC_LOCK;
    limits_apply_settings();
    TEST_ASSERT_EQUAL(MODBUS_ILLEGAL_VALUE, line(0, 1000, 5));
    check_refused(0, 1);
    discard(0);
    TEST_ASSERT_EQUAL(MODBUS_OK, line(0, 900, 5));
    check_edges(900);
}

// The same number is no change: nothing happens, whatever moves.
static void same_number_is_taken_in_any_state(void)
{
    TEST_ASSERT_EQUAL(MODBUS_OK, line(0, 2, 20));
    TEST_ASSERT_EQUAL(MODBUS_OK, line(0, 2, 20));
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(1, COMMAND_ARM));
    TEST_ASSERT_EQUAL(MODBUS_OK, line(0, 2, 20));
    TEST_ASSERT_TRUE(bench_until(0, AXIS_RUNNING));
    TEST_ASSERT_TRUE(reference_present());
    TEST_ASSERT_EQUAL(MODBUS_OK, line(0, 2, 20));
    TEST_ASSERT_EQUAL(MODBUS_OK, line(BENCH_LAST, 2, 20));
    TEST_ASSERT_TRUE(reference_present()); // a change forgets the clock
    store_begin();
    TEST_ASSERT_EQUAL(MODBUS_OK, line(BENCH_LAST, 2, 20));
    check_edges(2);
}

static void not_behind_a_queued_line(void)
{
    TEST_ASSERT_EQUAL(MODBUS_OK, line(0, 2, 20));
    TEST_ASSERT_EQUAL(MODBUS_ILLEGAL_VALUE, line(0, 3, 20));
    TEST_ASSERT_EQUAL(AXIS_REFUSED, axes_get(0)->life.state);
    check_refused(0, 2);
    discard(0);
    TEST_ASSERT_EQUAL(MODBUS_OK, line(0, 3, 20));
    check_edges(3);
}

// A line that runs is not ended by the one that is refused behind it.
static void not_behind_a_running_line(void)
{
    bench_plain_line(0, 20, 30);
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(1, COMMAND_ARM));
    TEST_ASSERT_EQUAL(MODBUS_ILLEGAL_VALUE, line(0, 3, 20));
    check_refused(0, 1);
    TEST_ASSERT_TRUE(bench_until(0, AXIS_RUNNING));
    TEST_ASSERT_EQUAL(MODBUS_ILLEGAL_VALUE, line(0, 3, 20));
    check_refused(0, 1);
    TEST_ASSERT_TRUE(bench_until(0, AXIS_DONE));
    TEST_ASSERT_EQUAL_INT32(600, ledger_position(&axes_get(0)->ledger));
    TEST_ASSERT_EQUAL(MODBUS_OK, line(0, 3, 20));
    check_edges(3);
}

static void not_beside_a_loaded_or_moving_axis(void)
{
    bench_plain_line(BENCH_LAST, 20, 30);
    TEST_ASSERT_EQUAL(MODBUS_ILLEGAL_VALUE, line(0, 3, 20));
    check_refused(0, 1);
    discard(0);
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(BENCH_MASK_OF(BENCH_LAST), COMMAND_ARM));
    TEST_ASSERT_EQUAL(MODBUS_ILLEGAL_VALUE, line(0, 3, 20));
    check_refused(0, 1);
    discard(0);
    TEST_ASSERT_TRUE(bench_until(BENCH_LAST, AXIS_RUNNING));
    TEST_ASSERT_EQUAL(MODBUS_ILLEGAL_VALUE, line(0, 3, 20));
    check_refused(0, 1);
    discard(0);
    TEST_ASSERT_TRUE(bench_until(BENCH_LAST, AXIS_DONE));
    TEST_ASSERT_EQUAL(MODBUS_OK, line(0, 3, 20));
    check_edges(3);
}

static void not_while_settings_are_stored(void)
{
    store_begin();
    TEST_ASSERT_EQUAL(MODBUS_ILLEGAL_VALUE, line(0, 3, 20));
    check_refused(0, 1);
    bench_rounds(300);
    discard(0);
    TEST_ASSERT_EQUAL(MODBUS_OK, line(0, 3, 20));
}

static void check_clock_known(void)
{
    TEST_ASSERT_TRUE(reference_settled());
    TEST_ASSERT_TRUE(reference_present());
}

// Not even for a moment: the board still knows its clock, and its settings are those stored.
static void a_refused_divider_leaves_clock_and_store_alone(void)
{
    bench_rounds(800);
    uint16_t stored = store_state();

    check_clock_known();
    TEST_ASSERT_EQUAL(MODBUS_ILLEGAL_VALUE,
                      BLOCK(0, HEAD(2), {fast, 3}, {30000, 1}, END));
    check_edges(1);
    check_clock_known();
    TEST_ASSERT_EQUAL_HEX16(stored, store_state());
    discard(0);
    TEST_ASSERT_EQUAL(MODBUS_OK, BLOCK(0, HEAD(2), {fast, 3}, END));
    check_edges(2);
    TEST_ASSERT_TRUE((store_state() & 2u) != 0);
}

// A block that is refused has changed nothing; of blocks, the one with the divider has.
static void refused_behind_its_divider(void)
{
    TEST_ASSERT_EQUAL(MODBUS_ILLEGAL_VALUE, BLOCK(0, HEAD(2), {fast, 3}, {0, 0}));
    TEST_ASSERT_EQUAL(LINE_malformed, axes_get(0)->line_error);
    check_edges(1);
    discard(0);
    TEST_ASSERT_EQUAL(MODBUS_OK, BLOCK(0, HEAD(2), {fast, 3}));
    TEST_ASSERT_EQUAL(MODBUS_ILLEGAL_VALUE, BLOCK(0, {0, 0}));
    check_edges(2);
}

static void repeated_block_changes_nothing(void)
{
    TEST_ASSERT_EQUAL(MODBUS_OK, line(0, 2, 20));
    discard(0);
    TEST_ASSERT_EQUAL(MODBUS_OK, write_setting(REG_HOLDING_divider, 7));
    // The host has lost the reply and sends the block again: only its number is looked at.
    uint8_t words[16];
    memset(words, 0, sizeof words);
    put_word(&words[0], (uint16_t)(axes_get(0)->next_block - 1u));
    put_word(&words[4], START);
    put_word(&words[12], 2);
    TEST_ASSERT_EQUAL(MODBUS_OK, data_write(REG_QUEUE_WINDOW, 8, words));
    check_edges(7);
    TEST_ASSERT_EQUAL(AXIS_EMPTY, axes_get(0)->life.state);
}

static void discarded_before_its_divider(void)
{
    TEST_ASSERT_EQUAL(MODBUS_OK, BLOCK(0, {(int16_t)START, 0}, {0, 0}));
    TEST_ASSERT_EQUAL(AXIS_LOADING, axes_get(0)->life.state);
    discard(0);
    check_edges(1);
    bench_plain_line(0, 20, 3);
    TEST_ASSERT_EQUAL(AXIS_LOADED, axes_get(0)->life.state);
    check_edges(1);
}

// Entries have places, not names: in the place of a divider, a start mark is one.
static void start_mark_in_the_dividers_place(void)
{
    TEST_ASSERT_EQUAL(MODBUS_OK, BLOCK(0, {(int16_t)START, 0}, {0, 0}));
    TEST_ASSERT_EQUAL(MODBUS_ILLEGAL_VALUE,
                      BLOCK(0, {LINE_MARK_START | LINE_START_WAIT, 0}, {0, 0}));
    TEST_ASSERT_EQUAL(LINE_malformed, axes_get(0)->line_error);
    check_edges(1);
}

static void two_dividers_of_a_line(void)
{
    TEST_ASSERT_EQUAL(MODBUS_ILLEGAL_VALUE, BLOCK(0, HEAD(4), {5, 0}, {20, 3}, END));
    TEST_ASSERT_EQUAL(LINE_malformed, axes_get(0)->line_error);
    check_edges(1);
}

// A pixel in the divider's place, or the end.
static void no_divider(void)
{
    TEST_ASSERT_EQUAL(MODBUS_ILLEGAL_VALUE,
                      BLOCK(0, {(int16_t)START, 0}, {0, 0}, {20, 3}, END));
    TEST_ASSERT_EQUAL(LINE_malformed, axes_get(0)->line_error);
    check_edges(1);
    discard(0);
    TEST_ASSERT_EQUAL(MODBUS_OK, BLOCK(0, {(int16_t)START, 0}, {0, 0}));
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(1, COMMAND_STOP));
    bench_rounds(20);
    TEST_ASSERT_EQUAL(MODBUS_OK, line(0, 3, 20));
    check_edges(3);
}

static void setting_between_mark_and_divider(void)
{
    TEST_ASSERT_EQUAL(MODBUS_OK, BLOCK(0, {(int16_t)START, 0}, {0, 0}));
    TEST_ASSERT_EQUAL(MODBUS_OK, write_setting(REG_HOLDING_divider, 7));
    TEST_ASSERT_EQUAL(MODBUS_OK, BLOCK(0, {2, 0}, {fast, 3}, END));
    check_edges(2);
    // From the first segment on the settings stay.
    TEST_ASSERT_EQUAL(MODBUS_BUSY, write_setting(REG_HOLDING_divider, 7));
    TEST_ASSERT_EQUAL(MODBUS_BUSY, write_setting(REG_HOLDING_sync, SYNC_FREE));
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(1, COMMAND_ARM));
    TEST_ASSERT_EQUAL(MODBUS_BUSY, write_setting(REG_HOLDING_divider, 7));
    check_edges(2);
}

// Two axes begin their lines at once, each with its own number: the first segment decides.
static void two_heads_at_once(void)
{
    TEST_ASSERT_EQUAL(MODBUS_OK, BLOCK(0, {(int16_t)START, 0}, {0, 0}));
    TEST_ASSERT_EQUAL(MODBUS_OK, BLOCK(BENCH_LAST, HEAD(3)));
    TEST_ASSERT_EQUAL(MODBUS_ILLEGAL_VALUE, BLOCK(0, {2, 0}, {20, 1}));
    check_refused(0, 3);
}

static void not_stored_by_this(void)
{
    TEST_ASSERT_EQUAL(MODBUS_OK, line(0, 3, 20));
    if (FEATURE_STORE) {
        TEST_ASSERT_EQUAL_HEX16(2, bench_input(REG_INPUT_settings_state) & 6u);
    }
    // What a reset does, by the watchdog or not.
    store_load();
    TEST_ASSERT_EQUAL_UINT16(1, settings_now()->divider);
    setUp();
}

// A line without the clock, and a seek.
static void other_lines(void)
{
    TEST_ASSERT_EQUAL(MODBUS_OK, BLOCK(0, {UNCLOCKED, 0}, {0, 0}, {4, 0}, {20, 3}, END));
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(1, COMMAND_ARM));
    TEST_ASSERT_TRUE(bench_until(0, AXIS_DONE));
    TEST_ASSERT_EQUAL_INT32(60, ledger_position(&axes_get(0)->ledger));
    check_edges(4);
    if (FEATURE_HOMING) {
        TEST_ASSERT_EQUAL(MODBUS_OK,
                          BLOCK(0,
                                {UNCLOCKED | LINE_START_SEEK, 0},
                                {0, 0},
                                {6, 0},
                                {2, 2},
                                {LINE_MARK_DOWN, 0},
                                {1, 1},
                                END));
        check_edges(6);
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(first_segment_has_the_lines_pixels);
    RUN_TEST(line_runs_by_its_pixels);
    RUN_TEST(head_stays_when_the_line_before_ends);
    RUN_TEST(head_behind_a_line_stays_behind_it);
    RUN_TEST(pieces_of_any_size);
    RUN_TEST(range_of_the_setting);
    RUN_TEST(pixel_that_cannot_be);
    RUN_TEST(same_number_is_taken_in_any_state);
    RUN_TEST(not_behind_a_queued_line);
    RUN_TEST(not_behind_a_running_line);
    RUN_TEST(not_beside_a_loaded_or_moving_axis);
    RUN_TEST(not_while_settings_are_stored);
    RUN_TEST(a_refused_divider_leaves_clock_and_store_alone);
    RUN_TEST(refused_behind_its_divider);
    RUN_TEST(repeated_block_changes_nothing);
    RUN_TEST(discarded_before_its_divider);
    RUN_TEST(start_mark_in_the_dividers_place);
    RUN_TEST(two_dividers_of_a_line);
    RUN_TEST(no_divider);
    RUN_TEST(setting_between_mark_and_divider);
    RUN_TEST(two_heads_at_once);
    RUN_TEST(not_stored_by_this);
    RUN_TEST(other_lines);
    return UNITY_END();
}
