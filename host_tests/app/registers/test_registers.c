// SPDX-License-Identifier: MIT
// The register map of the fake board.
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#include "fakes/board.h"
#include "fakes/board_bench.h"
#include "unity.h"
#include "wire/bytes.h"
#include "wire/register_map.h"

void setUp(void)
{
    bench_power_on();
}

void tearDown(void)
{
}

static uint16_t axis_input(uint8_t axis, uint16_t offset)
{
    return bench_input((uint16_t)(REG_AXIS_BASE + axis * REG_AXIS_STRIDE + offset));
}

static int32_t axis_wide(uint8_t axis, uint16_t offset)
{
    return (int32_t)bench_input_wide(
        (uint16_t)(REG_AXIS_BASE + axis * REG_AXIS_STRIDE + offset));
}

static enum modbus_exception write_word(uint16_t address, uint16_t word)
{
    uint8_t bytes[2];

    put_word(bytes, word);
    return data_write(address, 1, bytes);
}

static enum modbus_exception write_hz(uint32_t num, uint32_t den)
{
    uint8_t bytes[8];

    put_word(&bytes[0], (uint16_t)(num >> 16));
    put_word(&bytes[2], (uint16_t)num);
    put_word(&bytes[4], (uint16_t)(den >> 16));
    put_word(&bytes[6], (uint16_t)den);
    return data_write(REG_HOLDING_pixel_hz_num, 4, bytes);
}

static void start_line(int16_t count, uint16_t pixels)
{
    bench_plain_line(0, count, pixels);
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(1, COMMAND_ARM));
    TEST_ASSERT_TRUE(bench_until(0, AXIS_RUNNING));
}

static void board_describes_itself(void)
{
    TEST_ASSERT_EQUAL_UINT16(REG_MAP_VERSION, bench_input(REG_INPUT_map_version));
    TEST_ASSERT_EQUAL_UINT16(6, bench_input(0)); // what the host's tools know
    TEST_ASSERT_EQUAL_UINT16(CONFIG_VERSION_MAJOR * 256 + CONFIG_VERSION_MINOR,
                             bench_input(REG_INPUT_firmware_version));
    TEST_ASSERT_EQUAL_UINT16(CONFIG_BOARD_ID, bench_input(REG_INPUT_board_id));
    TEST_ASSERT_EQUAL_UINT16(CONFIG_AXES, bench_input(REG_INPUT_axis_count));
    TEST_ASSERT_EQUAL_UINT16(2, bench_input(REG_INPUT_reset_cause));
    TEST_ASSERT_EQUAL_UINT16(CONFIG_MIN_INTERVAL_TICKS,
                             bench_input(REG_INPUT_min_interval_ticks));
    TEST_ASSERT_EQUAL_UINT16(CONFIG_SMOOTH_MIN_INTERVAL_TICKS,
                             bench_input(REG_INPUT_smooth_min_interval_ticks));
    TEST_ASSERT_EQUAL_UINT16(BOARD_MIN_INTERVAL_1_TICKS,
                             bench_input(REG_INPUT_min_interval_1_ticks));
    TEST_ASSERT_EQUAL_UINT16(BOARD_SMOOTH_MIN_INTERVAL_3_TICKS,
                             bench_input(REG_INPUT_smooth_min_interval_3_ticks));
    TEST_ASSERT_EQUAL_UINT16(RECORDS_KEPT, bench_input(REG_INPUT_record_capacity));
    TEST_ASSERT_EQUAL_UINT8(CONFIG_BOARD_ID, data_server_id());
}

static void identity_text(void)
{
    uint8_t text[64];
    uint8_t length = data_identity(text, sizeof text);

    TEST_ASSERT_EQUAL_UINT8(sizeof "pixstep " CONFIG_BOARD_NAME " 0.1" - 1u, length);
    TEST_ASSERT_EQUAL_INT(0, memcmp(text, "pixstep " CONFIG_BOARD_NAME, 12));
    TEST_ASSERT_EQUAL_UINT8(3, data_identity(text, 3));
}

static void check_inputs(bool mapped, uint16_t address, uint16_t count)
{
    TEST_ASSERT_EQUAL(mapped, data_input_mapped(address, count));
}

static void mapped_inputs(void)
{
    // The areas of a board with four axes touch: a read may cross from one to the next.
    check_inputs(true, 0, REG_AXIS_BASE + CONFIG_AXES * REG_AXIS_STRIDE);
    check_inputs(CONFIG_AXES == 4, 20, REG_INPUT_features_high + 1 - 20);
    check_inputs(false, 20, REG_INPUT_features_high + 2 - 20);
    check_inputs(CONFIG_AXES == 4, REG_INPUT_fault_mask_high - 1, 2);
    check_inputs(true, REG_ROOM_BASE, CONFIG_AXES);
    check_inputs(false, REG_ROOM_BASE - 1, 2);
    check_inputs(false, REG_ROOM_BASE, CONFIG_AXES + 1);
    check_inputs(CONFIG_AXES == 4, REG_EVENT_BASE - 1, 2);
    check_inputs(CONFIG_AXES == 4, REG_EVENT_BASE - 100, 125);
    check_inputs(true, REG_INPUT_fault_mask_high, 38);
    check_inputs(false, REG_INPUT_fault_mask_high, 39);
    check_inputs(false, REG_INPUT_features_high + 1, 1);
    check_inputs(
        true, REG_RECORD_BASE + BENCH_LAST * REG_RECORD_STRIDE, REG_RECORD_STRIDE);
    check_inputs(false, REG_EVENT_BASE, 1 + CONFIG_EVENTS * REG_EVENT_WORDS + 1);
    check_inputs(false, REG_RECORD_BASE - 1, 2);
    check_inputs(false, 0xFFFF, 1);
    check_inputs(false, 0xFFFF, 125);
}

static void check_holdings(bool mapped, uint16_t address, uint16_t count)
{
    TEST_ASSERT_EQUAL(mapped, data_holding_mapped(address, count));
}

static void mapped_holdings(void)
{
    check_holdings(true, 0, SETTINGS_WORDS);
    check_holdings(false, 0, SETTINGS_WORDS + 1);
    check_holdings(false, SETTINGS_WORDS, 1);
    check_holdings(false, REG_HOLDING_clock_out_hz, 0x102);
    check_holdings(true, REG_HOLDING_axis_mask, 5);
    check_holdings(false, REG_HOLDING_axis_mask, 6);
    check_holdings(false, REG_HOLDING_axis_mask - 1, 2);
    check_holdings(true, REG_QUEUE_WINDOW, 122);
    check_holdings(false, REG_QUEUE_WINDOW + 1, 1);
}

static void settings_write_and_read_back(void)
{
    TEST_ASSERT_EQUAL(MODBUS_OK, write_hz(30000, 1001));
    TEST_ASSERT_EQUAL_UINT16(30000, data_holding(REG_HOLDING_pixel_hz_num + 1));
    TEST_ASSERT_EQUAL_UINT16(1001, data_holding(REG_HOLDING_pixel_hz_den + 1));
    TEST_ASSERT_EQUAL_UINT32((uint32_t)(CONFIG_TIMER_HZ / 30000uL * 1001u +
                                        CONFIG_TIMER_HZ % 30000uL * 1001u / 30000uL),
                             bench_input_wide(REG_INPUT_pixel_period_ticks));
    TEST_ASSERT_EQUAL(MODBUS_OK, write_word(REG_HOLDING_max_acceleration, 77));
    TEST_ASSERT_EQUAL_UINT16(77, data_holding(REG_HOLDING_max_acceleration));
    TEST_ASSERT_EQUAL_UINT16(77, limits_together(1)->max_acceleration);
}

// A finished line is no longer the reference of the clock once the period may have changed.
static void new_settings_end_the_watch(void)
{
    reference_follow(1000);
    TEST_ASSERT_EQUAL(MODBUS_ILLEGAL_VALUE, write_hz(30, 0));
    TEST_ASSERT_TRUE(reference_watch()->following);
    TEST_ASSERT_EQUAL(MODBUS_OK, write_hz(30000, 1001));
    TEST_ASSERT_FALSE(reference_watch()->following);
}

static void impossible_settings_change_nothing(void)
{
    TEST_ASSERT_EQUAL(MODBUS_ILLEGAL_VALUE, write_hz(30, 0));
    TEST_ASSERT_EQUAL(MODBUS_ILLEGAL_VALUE, write_hz(20000, 1));
    TEST_ASSERT_EQUAL(MODBUS_ILLEGAL_VALUE, write_hz(1, 2));
    TEST_ASSERT_EQUAL(MODBUS_ILLEGAL_VALUE, write_word(REG_HOLDING_unit_address, 0));
    TEST_ASSERT_EQUAL(MODBUS_ILLEGAL_VALUE, write_word(REG_HOLDING_unit_address, 248));
    TEST_ASSERT_EQUAL(MODBUS_ILLEGAL_VALUE, write_word(REG_HOLDING_unit_address, 257));
    TEST_ASSERT_EQUAL(MODBUS_ILLEGAL_VALUE, write_word(REG_HOLDING_dir_setup_us, 1001));
    TEST_ASSERT_EQUAL(MODBUS_ILLEGAL_VALUE, bench_command(16, COMMAND_ENABLE));
    TEST_ASSERT_EQUAL(MODBUS_ILLEGAL_VALUE, write_word(REG_HOLDING_command, 15));
    TEST_ASSERT_EQUAL_UINT32(BENCH_PIXEL_TICKS,
                             bench_input_wide(REG_INPUT_pixel_period_ticks));
    TEST_ASSERT_EQUAL_UINT16(1, data_holding(REG_HOLDING_unit_address));
}

static void direction_times_limit_reversals(void)
{
    TEST_ASSERT_EQUAL(MODBUS_OK, write_word(REG_HOLDING_dir_setup_us, 100));
    TEST_ASSERT_TRUE(limits_together(1)->reversal_min_ticks >= BENCH_TICKS_PER_MS / 5u);
    TEST_ASSERT_EQUAL(MODBUS_OK, write_word(REG_HOLDING_dir_hold_us, 1000));
    TEST_ASSERT_TRUE(limits_together(1)->reversal_min_ticks >= 2u * BENCH_TICKS_PER_MS);
}

// A queued line was checked against the settings at the time of its upload.
static void settings_are_busy_while_a_line_is_queued(void)
{
    bench_plain_line(0, 10, 20);
    TEST_ASSERT_EQUAL(MODBUS_BUSY, write_hz(25, 1));
    TEST_ASSERT_EQUAL_UINT32(BENCH_PIXEL_TICKS, reference_period()->whole_ticks);
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(1, COMMAND_DISCARD));
    TEST_ASSERT_EQUAL(MODBUS_OK, write_hz(25, 1));
}

static void settings_are_busy_while_moving(void)
{
    bench_plain_line(0, 10, 20);
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(1, COMMAND_ARM));
    TEST_ASSERT_EQUAL(MODBUS_BUSY, write_hz(30, 1));
    TEST_ASSERT_TRUE(bench_until(0, AXIS_RUNNING));
    TEST_ASSERT_EQUAL(MODBUS_BUSY, write_hz(30, 1));
    TEST_ASSERT_EQUAL(MODBUS_BUSY, write_word(REG_HOLDING_dir_hold_us, 50));
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(2, COMMAND_ENABLE));
    TEST_ASSERT_TRUE(bench_until(0, AXIS_DONE));
    TEST_ASSERT_EQUAL_INT32(200, fake_axes[0].steps);
    TEST_ASSERT_EQUAL(MODBUS_OK, write_hz(30, 1));
}

static void status_bits(void)
{
    TEST_ASSERT_EQUAL_HEX16(0, bench_input(REG_INPUT_status));
    bench_rounds(10);
    TEST_ASSERT_EQUAL_HEX16(1, bench_input(REG_INPUT_status));
    bench_plain_line(0, 10, 20);
    (void)bench_command(1, COMMAND_ARM);
    TEST_ASSERT_EQUAL_HEX16(3, bench_input(REG_INPUT_status));
    TEST_ASSERT_FALSE(data_running());
    TEST_ASSERT_TRUE(bench_until(0, AXIS_RUNNING));
    TEST_ASSERT_EQUAL_HEX16(5, bench_input(REG_INPUT_status));
    TEST_ASSERT_TRUE(data_running());
    faults_latch(FAULT_starved, 0, 0);
    TEST_ASSERT_EQUAL_HEX16(9, bench_input(REG_INPUT_status));
}

static void fault_registers(void)
{
    start_line(10, 50);
    bench_rounds(60);
    axes_get(0)->ledger.pixel = 0x12344;
    faults_latch(FAULT_underrun, 0, 0xBEEF);
    TEST_ASSERT_EQUAL_UINT16(FAULT_underrun, bench_input(REG_INPUT_fault_code));
    TEST_ASSERT_EQUAL_UINT16(0xBEEF, bench_input(REG_INPUT_fault_argument));
    TEST_ASSERT_EQUAL_UINT16(0, bench_input(REG_INPUT_fault_axis));
    TEST_ASSERT_EQUAL_HEX32(0x12345, bench_input_wide(REG_INPUT_fault_pixel));
    TEST_ASSERT_EQUAL_HEX16(1u << FAULT_underrun, bench_input(REG_INPUT_fault_mask));
    TEST_ASSERT_EQUAL_UINT16(AXIS_FAULT, axis_input(0, REG_AXIS_axis_state));
}

static void queue_registers(void)
{
    TEST_ASSERT_EQUAL_UINT16(CONFIG_QUEUE_ENTRIES, axis_input(1, REG_AXIS_queue_free));
    bench_plain_line(1, 10, 20);
    TEST_ASSERT_EQUAL_UINT16(CONFIG_QUEUE_ENTRIES - 4,
                             axis_input(1, REG_AXIS_queue_free));
    TEST_ASSERT_EQUAL_UINT16(CONFIG_QUEUE_BYTES - 16, bench_input(REG_ROOM_BASE + 1));
    TEST_ASSERT_EQUAL_UINT16(CONFIG_QUEUE_BYTES, bench_input(REG_ROOM_BASE));
    TEST_ASSERT_EQUAL_UINT16(4, axis_input(1, REG_AXIS_next_block));
    TEST_ASSERT_EQUAL_UINT16(AXIS_LOADED, axis_input(1, REG_AXIS_axis_state));
    TEST_ASSERT_EQUAL_UINT16(0, axis_input(0, REG_AXIS_next_block));
}

static void refusal_registers(void)
{
    (void)bench_entry(BENCH_THIRD, LINE_MARK_START | LINE_START_WAIT, 0);
    (void)bench_entry(BENCH_THIRD, 0, 0);
    (void)bench_entry(BENCH_THIRD, 1, 0xFFFF);
    (void)bench_entry(BENCH_THIRD, 1, 0x1000);
    TEST_ASSERT_EQUAL(MODBUS_ILLEGAL_VALUE, bench_entry(BENCH_THIRD, 20000, 1));
    TEST_ASSERT_EQUAL_UINT16(AXIS_REFUSED, axis_input(BENCH_THIRD, REG_AXIS_axis_state));
    TEST_ASSERT_EQUAL_UINT16(LINE_out_of_range,
                             axis_input(BENCH_THIRD, REG_AXIS_line_error));
    TEST_ASSERT_EQUAL_UINT32(0x11000, axis_wide(BENCH_THIRD, REG_AXIS_line_error_pixel));
}

static enum modbus_exception window(const uint16_t *words, uint8_t count)
{
    uint8_t bytes[20];

    for (uint8_t i = 0; i < count; i++) {
        put_word(&bytes[2u * i], words[i]);
    }
    return data_write(REG_QUEUE_WINDOW, count, bytes);
}

static void queue_window_rules(void)
{
    static const uint16_t first[] = {0, 0, 0x21, 0, 0, 0};
    static const uint16_t no_axis[] = {0, CONFIG_AXES, 0x21, 0};
    static const uint16_t wrong_block[] = {2, 0, 1, 1};

    TEST_ASSERT_EQUAL(MODBUS_ILLEGAL_VALUE, window(first, 2));
    TEST_ASSERT_EQUAL(MODBUS_ILLEGAL_VALUE, window(first, 3));
    TEST_ASSERT_EQUAL(MODBUS_ILLEGAL_VALUE, window(first, 5));
    TEST_ASSERT_EQUAL(MODBUS_ILLEGAL_VALUE, window(no_axis, 4));
    TEST_ASSERT_EQUAL(MODBUS_OK, window(first, 6));
    TEST_ASSERT_EQUAL(MODBUS_OK, window(first, 6));
    TEST_ASSERT_EQUAL_UINT16(CONFIG_QUEUE_ENTRIES - 2,
                             axis_input(0, REG_AXIS_queue_free));
    TEST_ASSERT_EQUAL(MODBUS_ILLEGAL_VALUE, window(wrong_block, 4));
    TEST_ASSERT_EQUAL_UINT16(AXIS_LOADING, axis_input(0, REG_AXIS_axis_state));
}

// Packed bytes behind a word of their number and the axis; a byte that only fills the last word is
// none of them.
static void queue_window_takes_packed_bytes(void)
{
    static const uint16_t line[] = {
        0, 0x0D01, 0x8021, 0, 0x8000, 0, 0x3D3E, 0x7105, 0x3880};
    static const uint16_t end[] = {1, 0x0401, 0x8002, 0};
    static const uint16_t no_axis[] = {0, 0x0400 + CONFIG_AXES, 0x8021, 0};
    static const uint16_t cut[] = {2, 0x0101, 0x8021};

    TEST_ASSERT_EQUAL(MODBUS_ILLEGAL_VALUE, window(line, 8));
    TEST_ASSERT_EQUAL(MODBUS_ILLEGAL_VALUE, window(no_axis, 4));
    TEST_ASSERT_EQUAL(MODBUS_ILLEGAL_VALUE, window(end, 2));
    TEST_ASSERT_EQUAL(MODBUS_OK, window(line, 9));
    TEST_ASSERT_EQUAL(MODBUS_OK, window(line, 9));
    TEST_ASSERT_EQUAL_UINT16(CONFIG_QUEUE_BYTES - 13, bench_input(REG_ROOM_BASE + 1));
    TEST_ASSERT_EQUAL_UINT16(AXIS_LOADING, axis_input(1, REG_AXIS_axis_state));
    TEST_ASSERT_EQUAL(MODBUS_OK, window(end, 4));
    TEST_ASSERT_EQUAL_UINT16(AXIS_LOADED, axis_input(1, REG_AXIS_axis_state));
    TEST_ASSERT_EQUAL(MODBUS_ILLEGAL_VALUE, window(cut, 3));
    TEST_ASSERT_EQUAL_UINT16(LINE_malformed, axis_input(1, REG_AXIS_line_error));
}

static void full_queue_is_busy(void)
{
    (void)bench_long_start(0);
    while (axis_input(0, REG_AXIS_queue_free) != 0) {
        TEST_ASSERT_EQUAL(MODBUS_OK, bench_entry(0, 1, 1));
    }
    TEST_ASSERT_EQUAL(MODBUS_BUSY, bench_entry(0, 1, 1));
    TEST_ASSERT_EQUAL_UINT16(AXIS_LOADED, axis_input(0, REG_AXIS_axis_state));
}

static void line_registers(void)
{
    start_line(-7, 13);
    TEST_ASSERT_TRUE(bench_until(0, AXIS_DONE));
    TEST_ASSERT_EQUAL_INT32(-91, axis_wide(0, REG_AXIS_position_steps));
    TEST_ASSERT_EQUAL_INT32(-91, axis_wide(0, REG_AXIS_expected_steps));
    TEST_ASSERT_EQUAL_INT32(13, axis_wide(0, REG_AXIS_pixel));
    TEST_ASSERT_EQUAL_UINT16(1, axis_input(0, REG_AXIS_lines_done));
    TEST_ASSERT_EQUAL_UINT16(0, axis_input(0, REG_AXIS_underruns));
    TEST_ASSERT_EQUAL_UINT16(0, axis_input(0, REG_AXIS_ring_fill));
    TEST_ASSERT_TRUE(bench_input_wide(REG_INPUT_pixel_edges) >= 13);
    TEST_ASSERT_EQUAL_UINT16(0, bench_input(REG_INPUT_edge_error_ticks));
}

// The word below the first one of an axis's position.
static uint16_t position_low(uint8_t axis)
{
    return axis_input(axis, (uint16_t)(REG_AXIS_position_steps + 1u));
}

static void position_is_as_new_as_its_first_word(void)
{
    start_line(10, 50);
    bench_rounds(100);
    fake_pass(3 * BENCH_PIXEL_TICKS / 10);
    int32_t steps = fake_axes[0].steps;

    TEST_ASSERT_EQUAL_UINT16(0, axis_input(0, REG_AXIS_position_steps));
    fake_pass(BENCH_PIXEL_TICKS / 2u);
    // The second word belongs to the first,
    TEST_ASSERT_INT16_WITHIN(2, steps, (int16_t)position_low(0));
    // alone it is as new as itself,
    TEST_ASSERT_INT16_WITHIN(2, fake_axes[0].steps, (int16_t)position_low(0));
    TEST_ASSERT_TRUE(fake_axes[0].steps >= steps + 4);
    // and it is never another axis's.
    (void)axis_input(0, REG_AXIS_position_steps);
    TEST_ASSERT_EQUAL_UINT16(0, position_low(BENCH_LAST));
}

static void last_order_is_read_back(void)
{
    TEST_ASSERT_EQUAL(MODBUS_OK,
                      bench_command(BENCH_MASK_OF(BENCH_LAST), COMMAND_ENABLE));
    TEST_ASSERT_EQUAL_UINT16(BENCH_MASK_OF(BENCH_LAST),
                             data_holding(REG_HOLDING_axis_mask));
    TEST_ASSERT_EQUAL_UINT16(COMMAND_ENABLE, data_holding(REG_HOLDING_axis_mask + 1));
}

static void write_tag(uint16_t tag)
{
    uint8_t words[2];

    put_word(words, tag);
    TEST_ASSERT_EQUAL(MODBUS_OK, data_write(REG_HOLDING_tag, 1, words));
}

// No order changes the tag, and the tag is none.
static void the_tag_is_kept_until_a_reset(void)
{
    TEST_ASSERT_EQUAL_UINT16(0, data_holding(REG_HOLDING_tag));
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(1, COMMAND_PERMIT_ON));
    write_tag(0xABCD);
    TEST_ASSERT_TRUE(permit_is_on());
    TEST_ASSERT_EQUAL_UINT16(1, data_holding(REG_HOLDING_axis_mask));
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(1, COMMAND_PERMIT_OFF));
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(1, COMMAND_STOP));
    TEST_ASSERT_EQUAL(MODBUS_ILLEGAL_VALUE, bench_command(16, COMMAND_ENABLE));
    TEST_ASSERT_EQUAL_HEX16(0xABCD, data_holding(REG_HOLDING_tag));
    start_line(10, 3);
    TEST_ASSERT_TRUE(bench_until(0, AXIS_DONE));
    TEST_ASSERT_EQUAL_HEX16(0xABCD, data_holding(REG_HOLDING_tag));
    write_tag(0);
    TEST_ASSERT_EQUAL_UINT16(0, data_holding(REG_HOLDING_tag));
}

static void every_mapped_input_can_be_read(void)
{
    for (uint16_t address = 0;
         address < (uint16_t)(REG_RECORD_BASE + 4 * REG_RECORD_STRIDE);
         address++) {
        if (data_input_mapped(address, 1)) {
            (void)data_input(address);
        }
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(board_describes_itself);
    RUN_TEST(identity_text);
    RUN_TEST(mapped_inputs);
    RUN_TEST(mapped_holdings);
    RUN_TEST(settings_write_and_read_back);
    RUN_TEST(new_settings_end_the_watch);
    RUN_TEST(impossible_settings_change_nothing);
    RUN_TEST(direction_times_limit_reversals);
    RUN_TEST(settings_are_busy_while_a_line_is_queued);
    RUN_TEST(settings_are_busy_while_moving);
    RUN_TEST(status_bits);
    RUN_TEST(fault_registers);
    RUN_TEST(queue_registers);
    RUN_TEST(refusal_registers);
    RUN_TEST(queue_window_rules);
    RUN_TEST(queue_window_takes_packed_bytes);
    RUN_TEST(full_queue_is_busy);
    RUN_TEST(line_registers);
    RUN_TEST(position_is_as_new_as_its_first_word);
    RUN_TEST(last_order_is_read_back);
    RUN_TEST(the_tag_is_kept_until_a_reset);
    RUN_TEST(every_mapped_input_can_be_read);
    return UNITY_END();
}
