// SPDX-License-Identifier: MIT
// The records of the pixels, as the register map of the fake board shows them.
#include <stdint.h>

#include "app/axes/axes.h" // axes_get
#include "app/axes/events.h"
#include "base/interlude.h"
#include "fakes/board.h"
#include "fakes/board_bench.h"
#include "unity.h"
#include "wire/bytes.h"
#include "wire/read_words.h" // read_words
#include "wire/register_map.h"
#include "wire/server_data.h"

static bool pixels_pass; // in every interlude one

// In the middle of a request.
void interlude(void)
{
    if (pixels_pass) {
        struct ledger *ledger = &axes_get(0)->ledger;
        ledger->pixel++;
        records_add(&ledger->records, (uint16_t)ledger->pixel, 7, 7);
    }
}

void setUp(void)
{
    pixels_pass = false;
    bench_power_on();
}

void tearDown(void)
{
}

static void start_line(int16_t count, uint16_t pixels)
{
    bench_plain_line(0, count, pixels);
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(1, COMMAND_ARM));
    TEST_ASSERT_TRUE(bench_until(0, AXIS_RUNNING));
}

static void check_record(uint8_t number, uint16_t pixel, int32_t steps)
{
    uint16_t at =
        (uint16_t)(REG_RECORD_BASE + REG_RECORD_HEADER + number * REG_RECORD_WORDS);

    TEST_ASSERT_EQUAL_UINT16(pixel, bench_input(at));
    TEST_ASSERT_EQUAL_INT32(steps, (int32_t)bench_input_wide((uint16_t)(at + 1u)));
    TEST_ASSERT_EQUAL_INT32(steps, (int32_t)bench_input_wide((uint16_t)(at + 3u)));
    TEST_ASSERT_EQUAL_UINT16(0, bench_input((uint16_t)(at + 5u)));
}

static void records_oldest_first(void)
{
    start_line(-7, RECORDS_KEPT + 3u);
    TEST_ASSERT_TRUE(bench_until(0, AXIS_DONE));
    TEST_ASSERT_EQUAL_UINT32(RECORDS_KEPT + 3u, bench_input_wide(REG_RECORD_BASE));
    TEST_ASSERT_EQUAL_UINT16(RECORDS_KEPT, bench_input(REG_RECORD_BASE + 2));
    for (uint8_t i = 0; i < RECORDS_KEPT; i++) {
        check_record(i, (uint16_t)(4u + i), -7 * (int32_t)(4 + i));
    }
}

static void records_of_a_short_line(void)
{
    TEST_ASSERT_EQUAL_UINT32(0, bench_input_wide(REG_RECORD_BASE));
    start_line(7, 3);
    TEST_ASSERT_TRUE(bench_until(0, AXIS_DONE));
    TEST_ASSERT_EQUAL_UINT32(3, bench_input_wide(REG_RECORD_BASE));
    TEST_ASSERT_EQUAL_UINT16(3, bench_input(REG_RECORD_BASE + 2));
    for (uint8_t i = 0; i < 3; i++) {
        check_record(i, (uint16_t)(1u + i), 7 * (int32_t)(1 + i));
    }
    check_record(3, 0, 0);
}

static void records_of_a_single_pixel(void)
{
    TEST_ASSERT_EQUAL_INT32(
        0, (int32_t)bench_input_wide(REG_AXIS_BASE + REG_AXIS_expected_steps));
    start_line(7, 1);
    TEST_ASSERT_TRUE(bench_until(0, AXIS_DONE));
    TEST_ASSERT_EQUAL_UINT32(1, bench_input_wide(REG_RECORD_BASE));
    TEST_ASSERT_EQUAL_UINT16(1, bench_input(REG_RECORD_BASE + 2));
    check_record(0, 1, 7);
}

// What a reply has together, of `count` registers from here on, is what each register has.
static uint8_t check_together(uint16_t address, uint8_t count)
{
    uint8_t bytes[2 * 125];
    uint8_t read = data_inputs(address, count, bytes);

    TEST_ASSERT_LESS_OR_EQUAL_UINT8(count, read);
    for (uint8_t i = 0; i < read; i++) {
        TEST_ASSERT_EQUAL_HEX16(bench_input((uint16_t)(address + i)),
                                get_word(&bytes[2u * i]));
    }
    return read;
}

static void records_are_read_together(void)
{
    uint16_t together = 0;

    TEST_ASSERT_EQUAL_UINT8(120,
                            check_together(REG_RECORD_BASE + REG_RECORD_HEADER, 120));
    start_line(-7, RECORDS_KEPT + 3u);
    TEST_ASSERT_TRUE(bench_until(0, AXIS_DONE));
    for (uint8_t offset = 0; offset <= 125u; offset++) {
        for (uint8_t count = 1; count <= 125u - offset; count = (uint8_t)(count + 5u)) {
            together =
                (uint16_t)(together + check_together(REG_RECORD_BASE + offset, count));
        }
    }
    TEST_ASSERT_EQUAL_UINT8(0, check_together(REG_RECORD_BASE + REG_RECORD_STRIDE, 60));
    TEST_ASSERT_TRUE(together > 1000u);
}

// Whatever passes in the middle of a reply, its header counts the records that follow.
static void header_and_records_are_of_one_moment(void)
{
    uint8_t bytes[2 * 124];

    start_line(-7, RECORDS_KEPT + 3u);
    TEST_ASSERT_TRUE(bench_until(0, AXIS_DONE));
    pixels_pass = true;
    (void)read_words(bytes, REG_RECORD_BASE, 124, true);
    pixels_pass = false;

    uint16_t newest = get_word(&bytes[2]);
    uint8_t count = (uint8_t)get_word(&bytes[4]);
    TEST_ASSERT_EQUAL_UINT16(RECORDS_KEPT + 4u, newest);
    TEST_ASSERT_EQUAL_UINT8(RECORDS_KEPT, count);
    for (uint8_t i = 0; i < count; i++) {
        TEST_ASSERT_EQUAL_UINT16(newest - (count - 1u) + i,
                                 get_word(&bytes[2u * (4u + 6u * i)]));
    }
}

// All registers from `first` on up to the one before `end`, from each of them on.
static void check_area(uint16_t first, uint16_t end)
{
    for (uint16_t address = first; address < end; address++) {
        TEST_ASSERT_EQUAL_UINT8(end - address, check_together(address, 125));
        TEST_ASSERT_EQUAL_UINT8(1, check_together(address, 1));
    }
}

static void registers_of_the_board_and_of_an_axis_are_read_together(void)
{
    start_line(-7, 3);
    TEST_ASSERT_TRUE(bench_until(0, AXIS_DONE));
    check_area(0, REG_AXIS_BASE);
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        uint16_t axis = (uint16_t)(REG_AXIS_BASE + i * REG_AXIS_STRIDE);
        uint16_t position = (uint16_t)(axis + REG_AXIS_position_steps);
        check_area(axis, position);
        check_area(position, (uint16_t)(axis + REG_AXIS_STRIDE));
    }
    check_area(REG_INPUT_fault_mask_high, REG_INPUT_features_high + 1u);
    TEST_ASSERT_EQUAL_UINT8(0, check_together(REG_ROOM_BASE, 1));
}

#define EVENTS_MOST 15u // of one request

static void events_are_read_together(void)
{
    TEST_ASSERT_EQUAL_UINT8(0, check_together(REG_EVENT_BASE, 125));
    for (uint8_t event = 0; event <= CONFIG_EVENTS; event++) {
        for (uint8_t i = 0; i < CONFIG_EVENTS; i++) {
            uint16_t first =
                (uint16_t)(REG_EVENT_BASE + REG_EVENT_HEADER + i * REG_EVENT_WORDS);
            uint8_t left = (uint8_t)(CONFIG_EVENTS - i);
            left = left > EVENTS_MOST ? EVENTS_MOST : left;
            TEST_ASSERT_EQUAL_UINT8(
                left * REG_EVENT_WORDS,
                check_together(first, (uint8_t)(left * REG_EVENT_WORDS + 5u)));
            TEST_ASSERT_EQUAL_UINT8(0, check_together(first, 7));
            TEST_ASSERT_EQUAL_UINT8(0, check_together((uint16_t)(first + 1u), 7));
        }
        events_note(event, 1, (uint16_t)(0x1234u + event), 0x12345678u);
    }
}

// The addresses at which hosts expect these registers.
static void each_axis_has_its_records(void)
{
    bench_plain_line(BENCH_LAST, 5, 2);
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(BENCH_MASK_OF(BENCH_LAST), COMMAND_ARM));
    TEST_ASSERT_TRUE(bench_until(BENCH_LAST, AXIS_DONE));
    TEST_ASSERT_EQUAL_UINT32(2, bench_input_wide(0x0100 + BENCH_LAST * 0x0080));
    TEST_ASSERT_EQUAL_UINT16(1, bench_input(0x0100 + BENCH_LAST * 0x0080 + 4));
    TEST_ASSERT_EQUAL_UINT32(0, bench_input_wide(0x0100 + BENCH_THIRD * 0x0080));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(records_oldest_first);
    RUN_TEST(records_of_a_short_line);
    RUN_TEST(records_of_a_single_pixel);
    if (SEVERAL_AXES) {
        RUN_TEST(records_are_read_together);
        RUN_TEST(header_and_records_are_of_one_moment);
        RUN_TEST(registers_of_the_board_and_of_an_axis_are_read_together);
        RUN_TEST(events_are_read_together);
    }
    RUN_TEST(each_axis_has_its_records);
    return UNITY_END();
}
