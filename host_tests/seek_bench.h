// SPDX-License-Identifier: MIT
// What the suites of seeks share: the board on its fake, a line that seeks, and the places of its
// steps.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "app/axes/axes.h"
#include "fakes/board.h"
#include "fakes/board_bench.h"
#include "unity.h"

#define TOP_STEPS    8
#define RAMP_STEPS   7 // 1 + 2 + 4
#define RAMP_PX      3
#define CLOSED       false
#define OPEN         true
#define FILTER_TICKS BENCH_TICKS_PER_MS // by default

void setUp(void)
{
    bench_power_on();
    bench_rounds(20);
}

void tearDown(void)
{
}

static inline void queue_entry(uint8_t axis, int16_t count, uint16_t repeat)
{
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_entry(axis, count, repeat));
}

// 1 2 4, 8 for so many pixels, 4 2 1; upwards or, with sign -1, downwards.
static inline void queue_seek(uint8_t axis, uint16_t flags, int16_t sign, uint16_t pixels)
{
    queue_entry(axis, (int16_t)(LINE_MARK_START | LINE_START_SEEK | flags), 0);
    queue_entry(axis, 0, 0);
    for (int16_t count = 1; count < TOP_STEPS; count = (int16_t)(2 * count)) {
        queue_entry(axis, (int16_t)(sign * count), 1);
    }
    queue_entry(axis, (int16_t)(sign * TOP_STEPS), pixels);
    queue_entry(axis, LINE_MARK_DOWN, 0);
    for (int16_t count = TOP_STEPS / 2; count != 0; count = (int16_t)(count / 2)) {
        queue_entry(axis, (int16_t)(sign * count), 1);
    }
    queue_entry(axis, LINE_MARK_END, 0);
}

static inline void start_seek(uint8_t axis)
{
    TEST_ASSERT_EQUAL(MODBUS_OK, bench_command((uint16_t)(1u << axis), COMMAND_ARM));
    TEST_ASSERT_TRUE(bench_until(axis, AXIS_RUNNING));
}

// Rounds until `ticks` after line zero, then as many more ticks as are left.
static inline void go_to(uint8_t axis, uint32_t ticks)
{
    uint32_t until = axes_get(axis)->zero_ticks + ticks;

    while ((int32_t)(until - fake_now_ticks()) > (int32_t)BENCH_ROUND_TICKS) {
        bench_rounds(1);
    }
    fake_pass(until - fake_now_ticks());
}

// Steps of such a seek at an instant after line zero: the last of each pixel on its end.
static inline int32_t steps_at(uint32_t ticks)
{
    static const uint16_t places[] = {16000, 24000, 32000, 36000, 40000, 44000, 48000};
    int32_t steps = 0;

    for (uint8_t i = 0; i < 7; i++) {
        steps += places[i] <= ticks;
    }
    if (ticks > 48000u) {
        steps += (int32_t)((ticks - 48000u) / 2000u);
    }
    return steps;
}
