// SPDX-License-Identifier: MIT
// What suites of the serial line share: the machine on the fake board, address 7, and its master.
#pragma once

#include <stdint.h>

#include "app/bus_port.h"
#include "app/traffic.h"
#include "base/flash.h"
#include "fakes/board.h"
#include "fakes/board_bench.h"
#include "hal/uart.h"
#include "unity.h"
#include "wire/crc16.h"

#define MS_TICKS      ((uint32_t)(CONFIG_TIMER_HZ / 1000uL))
#define SILENCE_TICKS ((uint32_t)fake_line.silence_counts * 256u)
#define SLACK_TICKS   256u

static const uint8_t *reply;

void setUp(void)
{
    bench_power_on();
    settings_override_address(7);
    bus_port_start();
    fake_pass(SILENCE_TICKS);
}

// Leave the line as it was found: the server's state outlives a test.
void tearDown(void)
{
    for (uint8_t i = 0; i < 4; i++) {
        fake_pass((uint32_t)30 * MS_TICKS);
        bus_port_poll();
    }
    (void)fake_sent(&reply);
}

static inline void put(const uint8_t *bytes, uint8_t length)
{
    uint16_t crc = crc16(bytes, length);
    uint8_t sum[2] = {(uint8_t)crc, (uint8_t)(crc >> 8)};

    fake_receive(bytes, length);
    fake_receive(sum, 2);
}

#define CONSTANTS_MAX 64u

// The same from flash.
static inline void put_constants(const uint8_t *constants, uint8_t length)
{
    uint8_t bytes[CONSTANTS_MAX];

    flash_copy(bytes, constants, length);
    put(bytes, length);
}

// A frame of constants, its checksum appended; it takes no RAM of the simulated board's.
#define PUT(...)                                                                         \
    do {                                                                                 \
        static const uint8_t constants[] IN_FLASH = {__VA_ARGS__};                       \
        _Static_assert(sizeof constants <= CONSTANTS_MAX, "room for them");              \
        put_constants(constants, sizeof constants);                                      \
    } while (0)

static inline uint16_t taken(void)
{
    return fake_sent(&reply);
}

// Each round takes one frame.
static inline void rounds(void)
{
    for (uint8_t i = 0; i < 16; i++) {
        bus_port_poll();
    }
}

// A long request is taken in one round, its reply made in the next, sealed and sent in another.
static inline uint16_t answer(void)
{
    rounds();
    fake_pass(SILENCE_TICKS + SLACK_TICKS);
    bus_port_poll();
    bus_port_poll();
    bus_port_poll();
    return taken();
}

// Until the reply has left.
static inline void sent(void)
{
    fake_pass((uint32_t)400 * MS_TICKS);
    bus_port_poll();
}

static inline void ask_axis_count(uint8_t unit)
{
    const uint8_t request[] = {unit, 4, 0, 3, 0, 1};

    put(request, sizeof request);
}

static inline void check_axis_count(void)
{
    TEST_ASSERT_EQUAL_UINT16(7, answer());
    TEST_ASSERT_EQUAL_HEX8(7, reply[0]);
    TEST_ASSERT_EQUAL_HEX8(4, reply[1]);
    TEST_ASSERT_EQUAL_UINT8(CONFIG_AXES, reply[4]);
    TEST_ASSERT_EQUAL_HEX16(0, crc16(reply, 7));
    sent();
}
