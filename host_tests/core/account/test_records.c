// SPDX-License-Identifier: MIT
// Records thinned to every Nth pixel and to deviations.
#include <stdint.h>

#include "account/records.h"
#include "cycles.h"
#include "unity.h"

static struct records records;
static uint16_t pixel;

static void begin(uint16_t every, uint16_t error_ticks)
{
    records_thin(every, error_ticks);
    records_reset(&records);
    pixel = 0;
}

void setUp(void)
{
    cycles_start();
    begin(1, UINT16_MAX);
}

void tearDown(void)
{
    records_thin(1, UINT16_MAX);
}

// Pass a pixel edge so many steps beyond the expected position, which moves by 10 steps a pixel.
static void pass(int16_t beyond_steps)
{
    pixel++;
    int32_t expected = 10 * (int32_t)pixel;

    records_add(&records, pixel, expected + beyond_steps, (uint16_t)expected);
}

static void pass_many(uint16_t pixels)
{
    for (; pixels != 0; pixels--) {
        pass(0);
    }
}

static void check_record(uint8_t number, uint16_t of_pixel, int16_t beyond, int16_t error)
{
    struct pixel_record record = records_get(&records, number);

    TEST_ASSERT_EQUAL_UINT16(of_pixel, record.pixel);
    TEST_ASSERT_EQUAL_INT32(10 * (int32_t)of_pixel, record.expected_steps);
    TEST_ASSERT_EQUAL_INT32(10 * (int32_t)of_pixel + beyond, record.actual_steps);
    TEST_ASSERT_EQUAL_INT16(error, record.edge_error_ticks);
    TEST_ASSERT_EQUAL_UINT16(of_pixel, records_word(&records, number, 0));
}

static void every_pixel(void)
{
    pass_many(3);
    TEST_ASSERT_EQUAL_UINT8(3, records_shown(&records));
    check_record(0, 1, 0, 0);
    check_record(2, 3, 0, 0);
    TEST_ASSERT_EQUAL_UINT16(3, records.made);
}

static void every_third_pixel(void)
{
    begin(3, UINT16_MAX);
    pass_many(2);
    TEST_ASSERT_EQUAL_UINT8(0, records_shown(&records));
    check_record(0, 2, 0, 0); // the newest pixel's is there all the same
    pass_many(6);
    TEST_ASSERT_EQUAL_UINT8(2, records_shown(&records));
    TEST_ASSERT_EQUAL_UINT16(2, records.made);
    check_record(0, 3, 0, 0);
    check_record(1, 6, 0, 0);
    check_record(2, 8, 0, 0);
}

static void positions_that_deviate(void)
{
    begin(100, UINT16_MAX);
    pass_many(4);
    pass(-1);
    pass(2);
    pass_many(2);
    TEST_ASSERT_EQUAL_UINT8(2, records_shown(&records));
    check_record(0, 5, -1, 0);
    check_record(1, 6, 2, 0);
    TEST_ASSERT_EQUAL_UINT16(2, records.made);
    pass_many(92); // a deviation moves none of the pixels that are due
    TEST_ASSERT_EQUAL_UINT8(3, records_shown(&records));
    check_record(2, 100, 0, 0);
}

// An edge error is kept when it has moved away from the one that was kept last: a drift makes few
// records, and each jump makes one.
static void edge_errors_that_change(void)
{
    static const int16_t errors[] = {3, 10, 11, 15, 21, 22, -900, -895, 0};
    static const uint16_t kept[] = {3, 6, 7, 9};

    begin(1000, 10);
    for (size_t i = 0; i < sizeof errors / sizeof errors[0]; i++) {
        pass(0);
        records_note_error(&records, pixel, errors[i]);
    }
    TEST_ASSERT_EQUAL_UINT16(4, records.made);
    TEST_ASSERT_EQUAL_UINT8(4, records_shown(&records));
    for (uint8_t i = 0; i < 4; i++) {
        check_record(i, kept[i], 0, errors[kept[i] - 1u]);
    }
}

static void limits_of_an_error(void)
{
    begin(1000, UINT16_MAX);
    pass(0);
    records_note_error(&records, 1, INT16_MIN);
    pass(0);
    records_note_error(&records, 2, INT16_MAX);
    TEST_ASSERT_EQUAL_UINT16(0, records.made);
    begin(1000, UINT16_MAX - 1u);
    pass(0);
    records_note_error(&records, 1, INT16_MIN);
    TEST_ASSERT_EQUAL_UINT16(0, records.made);
    begin(1000, 0);
    pass(0);
    records_note_error(&records, 1, INT16_MIN);
    pass(0);
    records_note_error(&records, 2, INT16_MAX);
    TEST_ASSERT_EQUAL_UINT16(2, records.made);
}

// An edge that is taken late belongs to its own pixel's record, as long as that is kept.
static void edges_behind_the_newest_pixel(void)
{
    begin(1, UINT16_MAX);
    pass_many(4);
    records_note_error(&records, 2, -7);
    records_note_error(&records, 3, 8);
    check_record(1, 2, 0, -7);
    check_record(2, 3, 0, 8);
    check_record(3, 4, 0, 0);
}

// An edge before its pixel's planned end belongs to the record that follows.
static void early_edges(void)
{
    begin(4, 10);
    pass(0);
    records_note_error(&records, 2, -11);
    pass(0);
    TEST_ASSERT_EQUAL_UINT8(1, records_shown(&records));
    check_record(0, 2, 0, -11);
    pass(0);
    records_note_error(&records, 3 + RECORDS_EARLY + 1u, 7); // no pixel near
    pass(0);
    check_record(1, 4, 0, 0);
}

// The account lags as far as it may, from before the first record on.
static void edges_of_many_pixels_ahead(void)
{
    begin(1, 10);
    for (uint16_t i = 1; i <= RECORDS_EARLY; i++) {
        records_note_error(&records, i, (int16_t)(-20 * (int16_t)i));
    }
    for (uint16_t i = 1; i <= RECORDS_EARLY; i++) {
        pass(0);
        records_note_error(&records, (uint16_t)(RECORDS_EARLY + i), (int16_t)i);
    }
    pass_many(RECORDS_EARLY);
    for (uint16_t i = 1; i <= RECORDS_EARLY; i++) {
        check_record((uint8_t)(i - 1u), i, 0, (int16_t)(-20 * (int16_t)i));
        check_record((uint8_t)(RECORDS_EARLY + i - 1u),
                     (uint16_t)(RECORDS_EARLY + i),
                     0,
                     (int16_t)i);
    }
    pass(0);
    check_record(2 * RECORDS_EARLY, 2 * RECORDS_EARLY + 1, 0, 0);
}

static void errors_of_pixels_without_record(void)
{
    begin(2, 10);
    pass_many(4);
    records_note_error(&records, 1, 9);
    records_note_error(&records, 3, 99); // none is passing
    records_note_error(&records, 2, 5);
    TEST_ASSERT_EQUAL_UINT8(2, records_shown(&records));
    check_record(0, 2, 0, 5);
    check_record(1, 4, 0, 0);
    begin(100, 10);
    pass_many(3);
    records_note_error(&records, 2, 9); // late, and no deviation
    TEST_ASSERT_EQUAL_UINT8(0, records_shown(&records));
    records_note_error(&records, 2, 11); // late: the newest takes it
    TEST_ASSERT_EQUAL_UINT8(1, records_shown(&records));
    check_record(0, 3, 0, 11);
}

static void the_oldest_record_takes_its_error(void)
{
    begin(2, 10);
    pass_many(2u * RECORDS_KEPT);
    records_note_error(&records, 2, 5);
    check_record(0, 2, 0, 5);
    check_record(1, 4, 0, 0);
    check_record(RECORDS_KEPT - 1u, 2u * RECORDS_KEPT, 0, 0);
}

// What an earlier line has left behind is no record of this one.
static void no_record_of_an_earlier_line_takes_an_error(void)
{
    pixel = (uint16_t)(2u - RECORDS_KEPT);
    pass_many(RECORDS_KEPT); // pixel 1 is the last but one
    begin(2, 10);
    pass_many(3);
    records_note_error(&records, 1, 11);
    TEST_ASSERT_EQUAL_UINT8(2, records_shown(&records));
    check_record(0, 2, 0, 0);
    check_record(1, 3, 0, 11);
}

static void pixel_numbers_wrap(void)
{
    begin(2, 10);
    pixel = 0xFFFD;
    records_add(&records, 0xFFFE, 0, 0);
    records_add(&records, 0xFFFF, 0, 0);
    records_add(&records, 0, 0, 0);
    records_add(&records, 1, 0, 0);
    records_note_error(&records, 0xFFFF, 4);
    TEST_ASSERT_EQUAL_INT16(4, records_get(&records, 0).edge_error_ticks);
    TEST_ASSERT_EQUAL_UINT16(1, records_get(&records, 1).pixel);
}

static void overwritten_records_are_counted(void)
{
    begin(2, 10);
    pass_many(2u * (RECORDS_KEPT + 5u));
    TEST_ASSERT_EQUAL_UINT16(RECORDS_KEPT + 5u, records.made);
    TEST_ASSERT_EQUAL_UINT8(RECORDS_KEPT, records_shown(&records));
    check_record(0, 2u * 6u, 0, 0);
    pass(0);
    TEST_ASSERT_EQUAL_UINT8(RECORDS_KEPT - 1u, records_shown(&records));
    check_record(0, 2u * 7u, 0, 0);
}

// Cycles of a pixel's record, on a board.
static void budgets(void)
{
    pass_many(3);
    uint16_t start = cycles_now();
    records_add(&records, 4, 40, 40);
    uint16_t added = cycles_now();
    records_note_error(&records, 4, 17);
    uint16_t noted = cycles_now();

    TEST_ASSERT_LESS_OR_EQUAL_UINT16(185, added - start);
    TEST_ASSERT_LESS_OR_EQUAL_UINT16(150, noted - added);
    begin(9, 10);
    pass_many(3);
    start = cycles_now();
    records_add(&records, 4, 40, 40);
    added = cycles_now();
    TEST_ASSERT_LESS_OR_EQUAL_UINT16(170, added - start);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(every_pixel);
    RUN_TEST(every_third_pixel);
    RUN_TEST(positions_that_deviate);
    RUN_TEST(edge_errors_that_change);
    RUN_TEST(limits_of_an_error);
    RUN_TEST(edges_behind_the_newest_pixel);
    RUN_TEST(early_edges);
    RUN_TEST(edges_of_many_pixels_ahead);
    RUN_TEST(errors_of_pixels_without_record);
    RUN_TEST(the_oldest_record_takes_its_error);
    RUN_TEST(no_record_of_an_earlier_line_takes_an_error);
    RUN_TEST(pixel_numbers_wrap);
    RUN_TEST(overwritten_records_are_counted);
    RUN_TEST(budgets);
    return UNITY_END();
}
