// SPDX-License-Identifier: MIT
#include <stdbool.h>
#include <stdint.h>

#include "app/settings.h"
#include "unity.h"
#include "wire/register_map.h"

static struct settings settings;

void setUp(void)
{
    settings_defaults(&settings);
}

void tearDown(void)
{
}

static uint16_t get(uint16_t address)
{
    uint16_t word = 0xDEAD;

    TEST_ASSERT_TRUE(settings_get(&settings, address, &word));
    return word;
}

static void set(uint16_t address, uint16_t word)
{
    TEST_ASSERT_TRUE(settings_set(&settings, address, word));
}

static void defaults(void)
{
    TEST_ASSERT_EQUAL_UINT16(1, settings.unit_address);
    TEST_ASSERT_EQUAL_UINT32(30, settings.pixel_hz_num);
    TEST_ASSERT_EQUAL_UINT32(1, settings.pixel_hz_den);
    TEST_ASSERT_EQUAL_UINT16(20, settings.dir_setup_us);
    TEST_ASSERT_EQUAL_UINT16(20, settings.dir_hold_us);
    TEST_ASSERT_EQUAL_UINT16(0, settings.max_acceleration);
    TEST_ASSERT_EQUAL_UINT16(0, settings.backlash_policy);
    TEST_ASSERT_TRUE(settings_in_range(&settings));
}

static void check_value(uint16_t address, uint16_t word, bool fits)
{
    set(address, word);
    TEST_ASSERT_EQUAL(fits, settings_in_range(&settings));
}

static void check_range(uint16_t address, uint16_t low, uint16_t high)
{
    setUp();
    if (low != 0) {
        check_value(address, (uint16_t)(low - 1u), false);
    }
    if (high != 0xFFFF) {
        check_value(address, (uint16_t)(high + 1u), false);
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
    check_range(REG_HOLDING_axis_mask, 0, 15);
    check_range(REG_HOLDING_command, 0, 8);
    check_range(REG_HOLDING_input_filter_us, 100, 20000);
    check_range(REG_HOLDING_inputs_inverted, 0, 3);
    check_range(REG_HOLDING_start_stop_steps, 0, 16383);
}

static void check_hz(bool fits, uint32_t num, uint32_t den)
{
    settings.pixel_hz_num = num;
    settings.pixel_hz_den = den;
    TEST_ASSERT_EQUAL(fits, settings_in_range(&settings));
}

static void wide_ranges(void)
{
    check_hz(false, 0, 1);
    check_hz(true, 0xFFFFFFFFuL, 1);
    check_hz(false, 30, 0);
    check_hz(true, 30, 0x10000uL);
}

static void halves_high_word_first(void)
{
    set(REG_HOLDING_pixel_hz_num, 0x1234);
    TEST_ASSERT_EQUAL_HEX32(0x1234001EuL, settings.pixel_hz_num);
    set(REG_HOLDING_pixel_hz_num + 1, 0xFEDC);
    TEST_ASSERT_EQUAL_HEX32(0x1234FEDCuL, settings.pixel_hz_num);
    TEST_ASSERT_EQUAL_HEX16(0x1234, get(REG_HOLDING_pixel_hz_num));
    TEST_ASSERT_EQUAL_HEX16(0xFEDC, get(REG_HOLDING_pixel_hz_num + 1));
    TEST_ASSERT_EQUAL_HEX32(1, settings.pixel_hz_den);
}

static void words_read_back(void)
{
    static const uint16_t addresses[] = {0, 2, 3, 4, 5, 6, 7, 8, 9, 0x100, 0x101};
    static const uint16_t words[] = {
        247, 0x8002, 0x8003, 0x8004, 0x8005, 0x8006, 0x8007, 0x8008, 1, 15, 7};

    for (uint8_t i = 0; i < (uint8_t)(sizeof addresses / sizeof addresses[0]); i++) {
        set(addresses[i], words[i]);
    }
    for (uint8_t i = 0; i < (uint8_t)(sizeof addresses / sizeof addresses[0]); i++) {
        TEST_ASSERT_EQUAL_HEX16(words[i], get(addresses[i]));
    }
}

// Their lowest bytes would fit.
static void words_too_large_for_a_byte(void)
{
    static const uint16_t addresses[] = {
        REG_HOLDING_unit_address,
        REG_HOLDING_backlash_policy,
        REG_HOLDING_axis_mask,
        REG_HOLDING_command,
    };

    for (uint8_t i = 0; i < (uint8_t)(sizeof addresses / sizeof addresses[0]); i++) {
        setUp();
        check_value(addresses[i], 0x101, false);
        check_value(addresses[i], 0xFF01, false);
        check_value(addresses[i], 1, true);
    }
}

static void gaps_are_not_mapped(void)
{
    static const uint16_t gaps[] = {1, 0x0D, 0xFF, 0x102, 0x1000, 0xFFFF};
    uint16_t word = 77;

    for (uint8_t i = 0; i < (uint8_t)(sizeof gaps / sizeof gaps[0]); i++) {
        TEST_ASSERT_FALSE(settings_get(&settings, gaps[i], &word));
        TEST_ASSERT_FALSE(settings_set(&settings, gaps[i], 5));
    }
    TEST_ASSERT_EQUAL_UINT16(77, word);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(defaults);
    RUN_TEST(ranges);
    RUN_TEST(wide_ranges);
    RUN_TEST(halves_high_word_first);
    RUN_TEST(words_read_back);
    RUN_TEST(words_too_large_for_a_byte);
    RUN_TEST(gaps_are_not_mapped);
    return UNITY_END();
}
