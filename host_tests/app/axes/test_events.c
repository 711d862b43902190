// SPDX-License-Identifier: MIT
#include <stdbool.h>
#include <stdint.h>

#include "app/axes/events.h"
#include "fakes/board.h"
#include "fakes/board_bench.h"
#include "unity.h"
#include "wire/register_map.h"

#define END                                                                              \
    ((uint16_t)(REG_EVENT_BASE + REG_EVENT_HEADER + CONFIG_EVENTS * REG_EVENT_WORDS))

void setUp(void)
{
    bench_power_on();
}

void tearDown(void)
{
}

static uint16_t word(uint16_t number, uint8_t which)
{
    return data_input(
        (uint16_t)(REG_EVENT_BASE + REG_EVENT_HEADER + number * REG_EVENT_WORDS + which));
}

static void nothing_at_first(void)
{
    events_start();
    TEST_ASSERT_EQUAL_UINT16(CONFIG_EVENTS, bench_input(REG_INPUT_event_capacity));
    TEST_ASSERT_EQUAL_UINT16(0, data_input(REG_EVENT_BASE));
    for (uint16_t at = REG_EVENT_BASE; at < END; at++) {
        TEST_ASSERT_EQUAL_UINT16(0, data_input(at));
    }
}

static void check_mapped(bool mapped, uint16_t address, uint16_t count)
{
    TEST_ASSERT_EQUAL(mapped, data_input_mapped(address, count));
}

static void mapped_as_far_as_it_goes(void)
{
    check_mapped(true, REG_EVENT_BASE, END - REG_EVENT_BASE);
    check_mapped(false, REG_EVENT_BASE, END - REG_EVENT_BASE + 1);
    check_mapped(true, END - 1, 1);
    check_mapped(false, END, 1);
}

static void the_reset_is_first(void)
{
    TEST_ASSERT_EQUAL_UINT16(1, data_input(REG_EVENT_BASE));
    TEST_ASSERT_EQUAL_UINT16(1, word(0, 0));
    TEST_ASSERT_EQUAL_HEX16(EVENT_RESET + 2, word(0, 1));
}

// The accounts count idle periods, which wrap after 16 s.
static void pass_seconds(uint8_t seconds)
{
    for (; seconds != 0; seconds--) {
        fake_pass(BENCH_TICKS_PER_MS * 1000uL);
        for (uint8_t i = 0; i < CONFIG_AXES; i++) {
            (void)axes_advance(i, LEDGER_EXACTLY);
        }
    }
}

static void a_fault_once_until_it_is_cleared(void)
{
    pass_seconds(70);
    axes_get(1)->ledger.pixel = 0x12344;
    faults_latch(FAULT_starved, 1, 0xBEEF);
    faults_latch(FAULT_starved, 1, 0xBEEF);
    faults_latch(FAULT_wrong_token, 0, 7);
    TEST_ASSERT_EQUAL_UINT16(3, data_input(REG_EVENT_BASE));
    TEST_ASSERT_EQUAL_UINT16(2, word(1, 0));
    TEST_ASSERT_EQUAL_UINT16(FAULT_starved, word(1, 1));
    TEST_ASSERT_EQUAL_UINT16(1, word(1, 2));
    TEST_ASSERT_EQUAL_HEX16(0xBEEF, word(1, 3));
    TEST_ASSERT_EQUAL_HEX16(0x0001, word(1, 4));
    TEST_ASSERT_EQUAL_HEX16(0x2345, word(1, 5));
    TEST_ASSERT_EQUAL_UINT16(70000uL >> 16, word(1, 6));
    TEST_ASSERT_UINT16_WITHIN(2, (uint16_t)70000uL, word(1, 7));
    TEST_ASSERT_EQUAL_UINT16(FAULT_wrong_token, word(2, 1));
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command(0, COMMAND_CLEAR_FAULT));
    faults_latch(FAULT_starved, 1, 0);
    TEST_ASSERT_EQUAL_UINT16(4, data_input(REG_EVENT_BASE));
}

static void the_newest_are_kept_oldest_first(void)
{
    for (uint16_t i = 0; i < CONFIG_EVENTS + 5u; i++) {
        events_note(FAULT_starved, 0, i, 0);
    }
    TEST_ASSERT_EQUAL_UINT16(CONFIG_EVENTS + 6u, data_input(REG_EVENT_BASE));
    for (uint16_t i = 0; i < CONFIG_EVENTS; i++) {
        TEST_ASSERT_EQUAL_UINT16(i + 7u, word(i, 0));
        TEST_ASSERT_EQUAL_UINT16(i + 5u, word(i, 3));
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(nothing_at_first);
    RUN_TEST(mapped_as_far_as_it_goes);
    RUN_TEST(the_reset_is_first);
    RUN_TEST(a_fault_once_until_it_is_cleared);
    RUN_TEST(the_newest_are_kept_oldest_first);
    return UNITY_END();
}
