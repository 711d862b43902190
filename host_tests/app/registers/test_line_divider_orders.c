// SPDX-License-Identifier: MIT
// Lines that say how many clock edges a pixel has, in random orders: while a segment is queued, or
// an axis moves, that number stays what it was when the segment was checked.
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#include "fakes/board_bench.h"
#include "fakes/chance.h"
#include "unity.h"
#include "wire/bytes.h"
#include "wire/register_map.h"

#define ACTIONS 2000u
#define SEEDS   5u
#define START   ((int16_t)(LINE_MARK_START | LINE_START_WAIT | LINE_START_DIVIDER))

// What the test knows of an axis's entries: how far its newest line is queued.
enum place {
    OUTSIDE,
    BEHIND_MARK,
    BEHIND_PARAMETER,
    INSIDE,
};

void setUp(void)
{
    bench_power_on();
}

void tearDown(void)
{
}

static enum place places[CONFIG_AXES];
static uint16_t changed;
static uint16_t kept_out;

// No axis moves, and none has a segment queued.
static bool nothing_queued(void)
{
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        const struct axis *axis = axes_get(i);

        if (lifecycle_moving(&axis->life) ||
            segment_queue_fill(&axis->queue) > 2u * SEGMENT_MOST) {
            return false;
        }
    }
    return true;
}

static void give_divider(uint8_t axis)
{
    uint16_t edges = (uint16_t)chance_between(0, 4);
    uint16_t before = settings_now()->divider;
    bool free = nothing_queued();
    bool possible = edges == before || (free && edges != 0);

    TEST_ASSERT_EQUAL(possible ? MODBUS_OK : MODBUS_ILLEGAL_VALUE,
                      bench_entry(axis, (int16_t)edges, 0));
    if (!possible) {
        TEST_ASSERT_EQUAL(LINE_divider, axes_get(axis)->line_error);
        TEST_ASSERT_EQUAL_UINT16(before, settings_now()->divider);
        if (!free) {
            kept_out++;
        }
        return;
    }
    TEST_ASSERT_EQUAL_UINT16(edges, settings_now()->divider);
    if (edges != before) {
        changed++;
    }
    places[axis] = INSIDE;
}

static bool takes_entries(uint8_t axis)
{
    uint8_t state = axes_get(axis)->life.state;

    return state != AXIS_REFUSED && state != AXIS_FAULT && state != AXIS_STOPPING &&
           segment_queue_free(&axes_get(axis)->queue) >= SEGMENT_MOST;
}

// The next entry of a line: a divider where its mark promises one, else a segment or the end.
static void give_entry(uint8_t axis)
{
    if (!takes_entries(axis)) {
        return;
    }
    // A stop has discarded what was queued, at once or rounds later.
    if (axes_get(axis)->life.state == AXIS_EMPTY) {
        places[axis] = OUTSIDE;
    }
    switch (places[axis]) {
    case OUTSIDE:
        (void)bench_entry(axis, START, 0);
        places[axis] = BEHIND_MARK;
        break;
    case BEHIND_MARK:
        (void)bench_entry(axis, 0, 0);
        places[axis] = BEHIND_PARAMETER;
        break;
    case BEHIND_PARAMETER:
        give_divider(axis);
        break;
    case INSIDE:
    default:
        if (chance_between(0, 1) == 0) {
            (void)bench_entry(axis, (int16_t)chance_between(1, 9), 1);
        } else {
            (void)bench_entry(axis, LINE_MARK_END, 0);
            places[axis] = OUTSIDE;
        }
        break;
    }
}

static void write_divider(void)
{
    uint16_t edges = (uint16_t)chance_between(1, 4);
    uint8_t words[2];

    put_word(words, edges);
    TEST_ASSERT_EQUAL(nothing_queued() ? MODBUS_OK : MODBUS_BUSY,
                      data_write(REG_HOLDING_divider, 1, words));
}

static void forget(uint8_t axis)
{
    (void)bench_command(BENCH_MASK_OF(axis), COMMAND_STOP);
    bench_rounds(20);
    (void)bench_command(BENCH_ALL_AXES, COMMAND_CLEAR_FAULT);
}

static void random_orders(uint32_t seed)
{
    uint16_t edges = 1;

    memset(places, OUTSIDE, sizeof places);
    chance_seed(seed);
    for (uint16_t i = 0; i < ACTIONS; i++) {
        uint8_t axis = (uint8_t)chance_between(0, CONFIG_AXES - 1u);
        bool free = nothing_queued();

        switch (chance_between(0, 11)) {
        case 0:
            write_divider();
            break;
        case 1:
            (void)bench_command(BENCH_MASK_OF(axis), COMMAND_ARM);
            break;
        case 2:
            forget(axis);
            break;
        case 3:
            bench_rounds((uint16_t)chance_between(1, 60));
            break;
        default:
            give_entry(axis);
            break;
        }
        if (!free) {
            TEST_ASSERT_EQUAL_UINT16(edges, settings_now()->divider);
        }
        edges = settings_now()->divider;
    }
}

// From power on again and again: what an axis did long ago must not decide.
static void every_order(void)
{
    changed = kept_out = 0;
    for (uint32_t seed = 0; seed < SEEDS; seed++) {
        bench_power_on();
        random_orders(seed);
    }
    TEST_ASSERT_TRUE(changed > 50);
    TEST_ASSERT_TRUE(kept_out > 50);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(every_order);
    return UNITY_END();
}
