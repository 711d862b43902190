// SPDX-License-Identifier: MIT
#include <stdbool.h>
#include <stdint.h>

#include "app/settings/settings.h"
#include "config.h"
#include "unity.h"
#include "wire/register_map.h"

// The settings as the store sees them: they may be written.
#define SETTINGS (*settings_record())

void setUp(void)
{
    settings_set_defaults();
}

void tearDown(void)
{
}

static void defaults(void)
{
    TEST_ASSERT_EQUAL_UINT16(1, SETTINGS.unit_address);
    TEST_ASSERT_EQUAL_UINT16(1152, SETTINGS.baud_100);
    TEST_ASSERT_EQUAL_UINT16(2, SETTINGS.parity);
    TEST_ASSERT_EQUAL_UINT32(30, settings_u32(SETTINGS.pixel_hz_num));
    TEST_ASSERT_EQUAL_UINT32(1, settings_u32(SETTINGS.pixel_hz_den));
    TEST_ASSERT_EQUAL_UINT16(20, SETTINGS.dir_setup_us);
    TEST_ASSERT_EQUAL_UINT16(20, SETTINGS.dir_hold_us);
    TEST_ASSERT_EQUAL_UINT16(1000, SETTINGS.input_filter_us);
    TEST_ASSERT_EQUAL_UINT16(3000, SETTINGS.bus_timeout_ms);
    TEST_ASSERT_TRUE(settings_are_possible());
}

// Each setting's word lies at its address.
static void words_by_address(void)
{
    SETTINGS.words[REG_HOLDING_unit_address] = 77;
    SETTINGS.words[REG_HOLDING_pixel_hz_num] = 0x1234;
    SETTINGS.words[REG_HOLDING_pixel_hz_num + 1] = 0xFEDC;
    SETTINGS.words[REG_HOLDING_enable_settle_ms] = 999;
    TEST_ASSERT_EQUAL_UINT16(77, SETTINGS.unit_address);
    TEST_ASSERT_EQUAL_HEX32(0x1234FEDCuL, settings_u32(SETTINGS.pixel_hz_num));
    TEST_ASSERT_EQUAL_HEX32(1, settings_u32(SETTINGS.pixel_hz_den));
    TEST_ASSERT_EQUAL_UINT16(999, SETTINGS.enable_settle_ms);
    TEST_ASSERT_EQUAL_UINT16(REG_HOLDING_clock_out_hz + 1, SETTINGS_WORDS);
}

static void check_value(uint16_t address, uint16_t word, bool possible)
{
    setUp();
    SETTINGS.words[address] = word;
    TEST_ASSERT_EQUAL(possible, settings_are_possible());
}

static void check_range(uint16_t address, uint16_t low, uint16_t high)
{
    if (low != 0) {
        check_value(address, (uint16_t)(low - 1u), false);
    }
    if (high != 0xFFFF) {
        check_value(address, (uint16_t)(high + 1u), false);
        check_value(address, 0xFFFF, false);
    }
    check_value(address, high, true);
    check_value(address, low, true);
}

static void ranges(void)
{
    check_range(REG_HOLDING_unit_address, 1, 247);
    check_range(REG_HOLDING_dir_setup_us, 1, 1000);
    check_range(REG_HOLDING_dir_hold_us, 1, 1000);
    check_range(REG_HOLDING_max_acceleration, 0, 0xFFFF);
    check_range(REG_HOLDING_backlash_policy, 0, 1);
    check_range(REG_HOLDING_input_filter_us, 100, 20000);
    check_range(REG_HOLDING_inputs_inverted, 0, 7);
    check_range(REG_HOLDING_start_stop_steps, 0, 16383);
    check_range(REG_HOLDING_parity, 0, 2);
    check_range(REG_HOLDING_reply_delay_us, 0, 20000);
    check_range(REG_HOLDING_bus_timeout_ms, 0, 60000);
    check_range(REG_HOLDING_idle_off_ms, 0, 60000);
    check_range(REG_HOLDING_enable_settle_ms, 0, 1000);
    check_range(REG_HOLDING_sync, 0, 2);
    check_range(REG_HOLDING_lock_tolerance_ppm, 100, 50000);
    check_range(REG_HOLDING_hold_over_edges, 0, 100);
    check_range(REG_HOLDING_record_every, 1, 10000);
    check_range(REG_HOLDING_home_is_limit, 0, 255);
    check_range(REG_HOLDING_gate_edges, 0, 1000);
    check_range(REG_HOLDING_clock_out_hz, 0, 2000);
}

static void check_hz(bool possible, uint32_t num, uint32_t den)
{
    SETTINGS.pixel_hz_num[0] = (uint16_t)(num >> 16);
    SETTINGS.pixel_hz_num[1] = (uint16_t)num;
    SETTINGS.pixel_hz_den[0] = (uint16_t)(den >> 16);
    SETTINGS.pixel_hz_den[1] = (uint16_t)den;
    TEST_ASSERT_EQUAL(possible, settings_are_possible());
}

// Each of the four words for itself would be possible.
static void pixel_frequencies_as_a_whole(void)
{
    check_hz(false, 0, 1);
    check_hz(false, 30, 0);
    check_hz(false, 0xFFFFFFFFuL, 1);
    check_hz(true, 0xFFFFFFFFuL, 0xFFFFFFFFuL / 30u);
    check_hz(true, 30, 1);
    check_hz(true, 30000, 1001);
    check_hz(false, 20000, 1);
    check_hz(false, 1, 2);
}

// The divider and the pixel frequency together make a pixel.
static void pixels_of_many_edges(void)
{
    SETTINGS.divider = 1000;
    check_hz(true, CONFIG_TIMER_HZ / 16000u, 1);
    check_hz(false, 0xFFFFFFFFuL, 0xFFFFFFFFuL / 1000u + 1u);
    check_hz(false, CONFIG_TIMER_HZ / 16800u, 1); // longer than 2^24 ticks
    SETTINGS.divider = 0;
    check_hz(false, 1000, 1);
    SETTINGS.divider = 1001;
    check_hz(false, 5000, 1);
    // A locked pixel may become longer.
    SETTINGS.divider = 1000;
    check_hz(true, CONFIG_TIMER_HZ / 16700u, 1);
    SETTINGS.sync = SYNC_LOCK;
    check_hz(false, CONFIG_TIMER_HZ / 16700u, 1);
    check_hz(true, CONFIG_TIMER_HZ / 15700u, 1);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(defaults);
    RUN_TEST(words_by_address);
    RUN_TEST(ranges);
    RUN_TEST(pixel_frequencies_as_a_whole);
    RUN_TEST(pixels_of_many_edges);
    return UNITY_END();
}
