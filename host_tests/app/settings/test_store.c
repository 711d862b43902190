// SPDX-License-Identifier: MIT
// Settings in two records: at every moment of a store either the old or the new settings are found.
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#include "app/settings/store.h"
#include "fakes/board_bench.h"
#include "fakes/eeprom.h"
#include "unity.h"

#define RECORD_BYTES ((uint8_t)sizeof(struct settings))
#define WRITES       ((uint16_t)(RECORD_BYTES + 1u)) // the first byte twice
#define SLOT         64u

void setUp(void)
{
    fake_eeprom_reset();
    store_load();
}

void tearDown(void)
{
}

static void store_all(uint16_t acceleration)
{
    bench_settings()->max_acceleration = acceleration;
    store_note_change();
    store_begin();
    for (uint16_t i = 0; i < 1000 && store_busy(); i++) {
        store_poll();
    }
    TEST_ASSERT_FALSE(store_busy());
}

static uint16_t found(void)
{
    memset(bench_settings(), 0xA5, sizeof(struct settings));
    store_load();
    return bench_settings()->max_acceleration;
}

static void erased_memory_gives_defaults(void)
{
    TEST_ASSERT_EQUAL_UINT16(1, bench_settings()->unit_address);
    TEST_ASSERT_EQUAL_UINT16(0, bench_settings()->serial);
    TEST_ASSERT_EQUAL_HEX16(0, store_state());
}

static void what_was_stored_comes_back(void)
{
    store_all(77);
    TEST_ASSERT_EQUAL_HEX16(1, store_state());
    TEST_ASSERT_EQUAL_UINT16(WRITES, fake_eeprom_writes);
    TEST_ASSERT_EQUAL_UINT16(77, found());
    TEST_ASSERT_EQUAL_UINT16(1, bench_settings()->serial);
    TEST_ASSERT_EQUAL_HEX16(1, store_state());
    TEST_ASSERT_EQUAL_UINT16(20, bench_settings()->dir_setup_us);
}

static void state_tells_changes_and_work(void)
{
    store_note_change();
    TEST_ASSERT_EQUAL_HEX16(2, store_state());
    store_begin();
    TEST_ASSERT_EQUAL_HEX16(6, store_state());
    store_poll();
    store_poll();
    TEST_ASSERT_EQUAL_UINT16(1, fake_eeprom_writes); // the second one waits
}

static void records_take_turns(void)
{
    for (uint16_t i = 1; i <= 5; i++) {
        store_all(i);
        TEST_ASSERT_EQUAL_UINT16((i & 1u) != 0 ? 0 : SLOT, fake_eeprom_last);
        TEST_ASSERT_EQUAL_UINT16(i, found());
        TEST_ASSERT_EQUAL_UINT16(i, bench_settings()->serial);
    }
}

static void numbers_wrap(void)
{
    bench_settings()->serial = 0xFFFE;
    store_all(1);
    store_all(2);
    TEST_ASSERT_EQUAL_UINT16(0, bench_settings()->serial);
    TEST_ASSERT_EQUAL_UINT16(2, found());
    store_all(3);
    TEST_ASSERT_EQUAL_UINT16(3, found());
}

// Cut off after `writes` bytes, the last of them left with any value.
static void cut(uint16_t writes, uint8_t undefined)
{
    uint8_t before[FAKE_EEPROM_BYTES];

    setUp();
    store_all(1);
    store_all(2);
    bench_settings()->max_acceleration = 3;
    memcpy(before, fake_eeprom, sizeof before);
    fake_eeprom_writes = 0;
    store_begin();
    while (fake_eeprom_writes < writes) {
        store_poll();
    }
    if (writes != 0) {
        fake_eeprom[fake_eeprom_last] = undefined;
    }
    uint16_t got = found();
    bool new = writes == WRITES && undefined == SETTINGS_VERSION;
    TEST_ASSERT_EQUAL_UINT16(new ? 3 : 2, got);
    TEST_ASSERT_EQUAL_UINT16(20, bench_settings()->dir_setup_us);
}

static void a_cut_leaves_the_old_or_the_new_settings(void)
{
    static const uint8_t undefined[] = {0x00, 0x01, 0x02, 0x2A, 0x80, 0xFF};

    for (uint16_t writes = 0; writes <= WRITES; writes++) {
        for (uint8_t i = 0; i < (uint8_t)sizeof undefined; i++) {
            cut(writes, undefined[i]);
        }
    }
}

// A damaged record of any kind is ignored, and the other record counts.
static void a_damaged_record_is_none(void)
{
    for (uint8_t i = 0; i < RECORD_BYTES; i++) {
        setUp();
        store_all(1);
        store_all(2);
        fake_eeprom[SLOT + i] ^= 0x10u;
        TEST_ASSERT_EQUAL_UINT16(1, found());
        fake_eeprom[i] ^= 0x10u;
        TEST_ASSERT_EQUAL_UINT16(0, found());
        TEST_ASSERT_EQUAL_HEX16(0, store_state());
    }
}

// Whole, but of another firmware whose limits were wider.
static void impossible_values_are_no_record(void)
{
    store_all(1);
    bench_settings()->unit_address = 300;
    store_all(2);
    TEST_ASSERT_EQUAL_UINT16(1, found());
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(erased_memory_gives_defaults);
    RUN_TEST(what_was_stored_comes_back);
    RUN_TEST(state_tells_changes_and_work);
    RUN_TEST(records_take_turns);
    RUN_TEST(numbers_wrap);
    RUN_TEST(a_cut_leaves_the_old_or_the_new_settings);
    RUN_TEST(a_damaged_record_is_none);
    RUN_TEST(impossible_values_are_no_record);
    return UNITY_END();
}
