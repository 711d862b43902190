// SPDX-License-Identifier: MIT
#include <stdint.h>

#include "clock/pixel_period.h"
#include "fakes/chance.h"
#include "unity.h"

#define TIMER_HZ 16000000uL

static struct pixel_period period;
static struct pixel_grid grid;
static struct pixel_grid shift;

void setUp(void)
{
    period = (struct pixel_period){1, 2, 3};
}

void tearDown(void)
{
}

static void set(uint32_t num, uint32_t den)
{
    TEST_ASSERT_TRUE(pixel_period_set(&period, TIMER_HZ, num, den));
}

// floor(k * P)
static uint64_t place(uint32_t k, uint32_t num, uint32_t den)
{
    return (uint64_t)TIMER_HZ * den * k / num;
}

static void three_pixels_of_30_hz(void)
{
    set(30, 1);
    TEST_ASSERT_EQUAL_UINT32(533333uL, period.whole_ticks);
    pixel_grid_start(&grid, &period);
    TEST_ASSERT_EQUAL_UINT32(533333uL, pixel_grid_advance(&grid));
    TEST_ASSERT_EQUAL_UINT32(533333uL, pixel_grid_advance(&grid));
    TEST_ASSERT_EQUAL_UINT32(533334uL, pixel_grid_advance(&grid));
    TEST_ASSERT_EQUAL_UINT32(0, grid.sum);
}

// Every place is summed up, but only every 97th is compared, because divisions take the board long.
static void no_drift(uint32_t num, uint32_t den, uint32_t pixels)
{
    uint64_t at = 0;

    set(num, den);
    pixel_grid_start(&grid, &period);
    for (uint32_t k = 1; k <= pixels; k++) {
        at += pixel_grid_advance(&grid);
        if (k % 97u == 0 || k == pixels) {
            TEST_ASSERT_EQUAL_UINT64(place(k, num, den), at);
        }
    }
}

static void no_drift_at_30_hz(void)
{
    no_drift(30, 1, 100000uL);
}

static void no_drift_at_29_97_hz(void)
{
    no_drift(2997, 100, 100000uL);
}

static void no_drift_at_ntsc_rate(void)
{
    no_drift(30000, 1001, 100000uL);
}

static void no_drift_with_large_terms(void)
{
    no_drift(4294967291uL, 143165577uL, 5000);
}

static void no_shift_is_the_grid_itself(void)
{
    set(30000, 1001);
    uint64_t at = pixel_grid_start_shifted(&shift, &period, 0, 32767);

    for (uint32_t k = 1; k <= 1000; k++) {
        TEST_ASSERT_EQUAL_UINT64(place(k, 30000, 1001), at);
        at += pixel_grid_advance(&shift);
    }
}

static void refused(uint32_t num, uint32_t den)
{
    TEST_ASSERT_FALSE(pixel_period_set(&period, TIMER_HZ, num, den));
    TEST_ASSERT_EQUAL_UINT32(1, period.whole_ticks);
    TEST_ASSERT_EQUAL_UINT32(2, period.remainder);
    TEST_ASSERT_EQUAL_UINT32(3, period.divisor);
}

static void zero_terms_refused(void)
{
    refused(0, 1);
    refused(30, 0);
    refused(0, 0);
}

static void limits_refused(void)
{
    refused(15626, 1);              // 1023.9 ticks
    refused(1, 2);                  // 2 s
    refused(TIMER_HZ, 0x1000000uL); // 2^24 ticks
    refused(0xFFFFFFFFuL, 1);
    refused(1, 0xFFFFFFFFuL);
}

static void limits_accepted(void)
{
    set(15625, 1);
    TEST_ASSERT_EQUAL_UINT32(PIXEL_PERIOD_MIN_TICKS, period.whole_ticks);
    set(TIMER_HZ, PIXEL_PERIOD_MAX_TICKS);
    TEST_ASSERT_EQUAL_UINT32(PIXEL_PERIOD_MAX_TICKS, period.whole_ticks);
    TEST_ASSERT_EQUAL_UINT32(0, period.remainder);
}

// Places (k + (V - B) / V) * P = P * (k V + V - B) / V from the shift on.
static void check_shift(uint32_t num, uint32_t den, uint16_t backlash, uint16_t speed)
{
    set(num, den);
    uint64_t at = pixel_grid_start_shifted(&shift, &period, backlash, speed);

    for (uint16_t k = 0; k < 40; k++) {
        uint32_t parts = (uint32_t)k * speed + speed - backlash;
        TEST_ASSERT_EQUAL_UINT64(
            (uint64_t)TIMER_HZ * den * parts / ((uint64_t)num * speed), at);
        at += pixel_grid_advance(&shift);
    }
}

static void shift_by_backlash(void)
{
    check_shift(30, 1, 250, 1000);
    check_shift(30, 1, 1, 1000);
    check_shift(30, 1, 999, 1000);
    check_shift(30000, 1001, 333, 998);
    check_shift(2997, 100, 1, 32766);
    check_shift(2997, 100, 16383, 32766);
}

// floor(P * parts / speed) from the period's own terms: they leave no room for a product of all.
static uint64_t shifted_place(uint32_t parts, uint16_t speed)
{
    uint64_t whole = (uint64_t)period.whole_ticks * parts;
    uint64_t rest = whole % speed * period.divisor + (uint64_t)period.remainder * parts;

    return whole / speed + rest / ((uint64_t)period.divisor * speed);
}

static void check_shift_with_large_terms(uint32_t num, uint32_t den)
{
    uint16_t speed = (uint16_t)chance_between(2, 32766);
    uint16_t backlash = (uint16_t)chance_between(1, (chance() & 1u) != 0 ? speed : 9u);

    backlash = backlash > speed ? speed : backlash;
    set(num, den);
    uint64_t at = pixel_grid_start_shifted(&shift, &period, backlash, speed);
    for (uint16_t k = 0; k < 20; k++) {
        TEST_ASSERT_EQUAL_UINT64(
            shifted_place((uint32_t)k * speed + speed - backlash, speed), at);
        at += pixel_grid_advance(&shift);
    }
}

// Near the largest divisor a fraction of the shift may have more than 32 bits.
static void shift_with_large_terms(void)
{
    chance_seed(0x5EED0021uL);
    for (uint8_t i = 0; i < 250; i++) {
        uint32_t num = 0xFFFFFFFFuL - chance_between(0, 1000);
        check_shift_with_large_terms(num, chance_between(300000uL, 200000000uL));
    }
}

static void shift_by_all_or_nothing(void)
{
    set(30, 1);
    TEST_ASSERT_EQUAL_UINT32(0, pixel_grid_start_shifted(&shift, &period, 1000, 1000));
    TEST_ASSERT_EQUAL_UINT32(533333uL,
                             pixel_grid_start_shifted(&shift, &period, 0, 1000));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(three_pixels_of_30_hz);
    RUN_TEST(no_drift_at_30_hz);
    RUN_TEST(no_drift_at_29_97_hz);
    RUN_TEST(no_drift_at_ntsc_rate);
    RUN_TEST(no_drift_with_large_terms);
    RUN_TEST(no_shift_is_the_grid_itself);
    RUN_TEST(zero_terms_refused);
    RUN_TEST(limits_refused);
    RUN_TEST(limits_accepted);
    RUN_TEST(shift_by_backlash);
    RUN_TEST(shift_with_large_terms);
    RUN_TEST(shift_by_all_or_nothing);
    return UNITY_END();
}
