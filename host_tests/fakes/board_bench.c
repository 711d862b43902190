// SPDX-License-Identifier: MIT
#include "fakes/board_bench.h"

#include <string.h>

#include "app/axes/events.h"
#include "app/axes/mark.h"
#include "app/board.h"
#include "app/bus/traffic.h"
#include "app/round.h"
#include "app/watch/drivers.h"
#include "app/watch/inputs.h"
#include "app/watch/safety.h"
#include "app/watch/time_check.h"
#include "fakes/board.h"
#include "fakes/eeprom.h"
#include "wire/bytes.h"
#include "wire/register_map.h"

#define FIRST_EDGE_TICKS 5000u
// Three quarters of the queue and one entry more: a line without its end may then be armed.
#define LONG_ENTRIES (CONFIG_QUEUE_ENTRIES / 4u * 3u + 1u)

void bench_clock_on(void)
{
    fake_pixel_clock(fake_now_ticks() + FIRST_EDGE_TICKS, BENCH_PIXEL_HZ, 1);
}

void bench_clock_off(void)
{
    fake_pixel_clock(0, 0, 0);
}

// Clear everything that a reset of a board clears.
static void forget(void)
{
    drivers_start();
    events_start();
    faults_start();
    inputs_start();
    permit_set(false);
    round_start();
    token_set(0);
    traffic_start();
    mark_disturb();
}

void bench_power_on(void)
{
    fake_power_on();
    fake_eeprom_reset();
    forget();
    board_start();
    bench_settings()->pixel_hz_num[1] = BENCH_PIXEL_HZ;
    limits_apply_settings();
    time_check_start();
    safety_start();
    bench_clock_on();
}

// A test that changes a setting here stands for a host that has written it. The value is not
// checked, and the change has no other effect.
struct settings *bench_settings(void)
{
    return settings_record();
}

bool bench_give(uint8_t mask, enum command command, uint16_t argument)
{
    const struct order order = {mask,
                                (uint16_t)command,
                                argument,
                                command == COMMAND_GO ? bench_edge_ahead(BENCH_GO_EDGES)
                                                      : 0};

    return commands_give(&order);
}

uint16_t bench_edge_ahead(uint16_t edges)
{
    uint16_t edge = (uint16_t)(reference_number() + edges);

    return edge != 0 ? edge : 1u; // 0 names no edge
}

uint8_t bench_axes_in(enum axis_state state)
{
    uint8_t mask = 0;

    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        if (axes_get(i)->life.state == (uint8_t)state) {
            mask = (uint8_t)(mask | axis_bit(i));
        }
    }
    return mask;
}

void bench_rounds(uint16_t rounds)
{
    for (; rounds != 0; rounds--) {
        fake_pass(BENCH_ROUND_TICKS);
        round_poll();
    }
}

bool bench_until(uint8_t axis, enum axis_state state)
{
    for (uint16_t i = 0; i < BENCH_ROUNDS_MAX; i++) {
        if (axes_get(axis)->life.state == (uint8_t)state) {
            return true;
        }
        bench_rounds(1);
    }
    return false;
}

enum modbus_exception bench_entry(uint8_t axis, int16_t count, uint16_t repeat)
{
    uint8_t words[8];

    put_word(&words[0], axes_get(axis)->next_block);
    put_word(&words[2], axis);
    put_word(&words[4], (uint16_t)count);
    put_word(&words[6], repeat);
    return data_write(REG_QUEUE_WINDOW, 4, words);
}

static void start_plain(uint8_t axis)
{
    (void)bench_entry(axis, LINE_MARK_START | LINE_START_WAIT, 0);
    (void)bench_entry(axis, 0, 0);
}

void bench_plain_line(uint8_t axis, int16_t count, uint16_t pixels)
{
    start_plain(axis);
    (void)bench_entry(axis, count, pixels);
    (void)bench_entry(axis, LINE_MARK_END, 0);
}

int32_t bench_long_start(uint8_t axis)
{
    int32_t steps = 0;

    start_plain(axis);
    for (uint8_t i = 2; i < (uint8_t)LONG_ENTRIES; i++) {
        int16_t count = (int16_t)(1 + (i & 1));
        (void)bench_entry(axis, count, 1);
        steps += count;
    }
    return steps;
}

enum modbus_exception bench_command(uint16_t mask, enum command command)
{
    uint8_t words[4];

    put_word(&words[0], mask);
    put_word(&words[2], (uint16_t)command);
    return data_write(REG_HOLDING_axis_mask, 2, words);
}

uint16_t bench_input(uint16_t address)
{
    return data_input(address);
}

uint32_t bench_input_wide(uint16_t address)
{
    return (uint32_t)data_input(address) << 16 | data_input((uint16_t)(address + 1u));
}
