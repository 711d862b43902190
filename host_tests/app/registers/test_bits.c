// SPDX-License-Identifier: MIT
// Coils and discrete inputs of the machine on the fake board.
#include <stdbool.h>
#include <stdint.h>

#include "app/registers/bits.h"
#include "fakes/board.h"
#include "fakes/board_bench.h"
#include "hal/switches.h"
#include "unity.h"
#include "wire/register_map.h"
#include "wire/server.h"

#define DRIVER 0u
#define ARMED  4u
#define STOP   8u
#define CLEAR  12u
#define PERMIT 13u

void setUp(void)
{
    bench_power_on();
}

void tearDown(void)
{
}

static bool coil(uint8_t address)
{
    return data_bit(address, SERVER_COILS);
}

static enum modbus_exception write(uint8_t address, uint8_t count, uint16_t values)
{
    const uint8_t bytes[2] = {(uint8_t)values, (uint8_t)(values >> 8)};

    TEST_ASSERT_EQUAL(true, data_bits_mapped(address, count, SERVER_COILS));
    return data_write_coils(address, count, bytes);
}

static void load(uint8_t axis)
{
    bench_plain_line(axis, 10, 20);
    TEST_ASSERT_EQUAL(AXIS_LOADED, axes_get(axis)->life.state);
}

static void as_many_are_mapped_as_there_are(void)
{
    TEST_ASSERT_EQUAL(CONFIG_AXES == 4, data_bits_mapped(0, BITS_COILS, SERVER_COILS));
    TEST_ASSERT_EQUAL(false, data_bits_mapped(0, BITS_COILS + 1, SERVER_COILS));
    TEST_ASSERT_EQUAL(false, data_bits_mapped(BITS_COILS, 1, SERVER_COILS));
    TEST_ASSERT_EQUAL(true, data_bits_mapped(0, BITS_INPUTS, SERVER_DISCRETE));
    TEST_ASSERT_EQUAL(false, data_bits_mapped(1, BITS_INPUTS, SERVER_DISCRETE));
    TEST_ASSERT_EQUAL(false, data_bits_mapped(0xFFFF, 2, SERVER_DISCRETE));
    TEST_ASSERT_EQUAL(false, data_bits_mapped(0xFFFF, 2000, SERVER_COILS));
}

static void discrete_inputs_are_two_registers(void)
{
    fake_switch(1, SWITCH_HOME, false);
    bench_rounds(200);
    uint16_t status = bench_input(REG_INPUT_status);
    uint16_t inputs = bench_input(REG_INPUT_inputs);

    TEST_ASSERT_NOT_EQUAL(0, status);
    TEST_ASSERT_NOT_EQUAL(0, inputs);
    for (uint8_t i = 0; i < 16; i++) {
        TEST_ASSERT_EQUAL(status >> i & 1, data_bit(i, SERVER_DISCRETE));
        TEST_ASSERT_EQUAL(inputs >> i & 1, data_bit((uint16_t)(16 + i), SERVER_DISCRETE));
    }
}

static void drivers_are_switched_and_read(void)
{
    TEST_ASSERT_EQUAL(MODBUS_OK, write(DRIVER + BENCH_LAST, 1, 1));
    TEST_ASSERT_EQUAL(true, fake_axes[BENCH_LAST].enabled && coil(DRIVER + BENCH_LAST));
    TEST_ASSERT_EQUAL(false, fake_axes[0].enabled || coil(DRIVER));
    TEST_ASSERT_EQUAL(
        MODBUS_OK,
        write(DRIVER, CONFIG_AXES, BENCH_ALL_AXES & ~BENCH_MASK_OF(BENCH_LAST)));
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        TEST_ASSERT_EQUAL(i != BENCH_LAST, fake_axes[i].enabled);
        TEST_ASSERT_EQUAL(i != BENCH_LAST, coil((uint8_t)(DRIVER + i)));
    }
}

static void axes_are_armed_and_disarmed(void)
{
    load(1);
    TEST_ASSERT_EQUAL(false, coil(ARMED + 1));
    TEST_ASSERT_EQUAL(MODBUS_OK, write(ARMED + 1, 1, 1));
    TEST_ASSERT_EQUAL(true, coil(ARMED + 1));
    TEST_ASSERT_EQUAL(false, coil(ARMED));
    TEST_ASSERT_EQUAL(MODBUS_OK, write(ARMED + 1, 1, 0));
    TEST_ASSERT_EQUAL(false, coil(ARMED + 1));
    TEST_ASSERT_EQUAL(AXIS_EMPTY, axes_get(1)->life.state);
}

static void running_axis_reads_armed_and_stops(void)
{
    bench_plain_line(0, 10, 200);
    TEST_ASSERT_EQUAL(MODBUS_OK, write(ARMED, 1, 1));
    TEST_ASSERT_EQUAL(true, bench_until(0, AXIS_RUNNING));
    while (fake_axes[0].steps == 0) {
        bench_rounds(1);
    }
    TEST_ASSERT_EQUAL(true, coil(ARMED));
    TEST_ASSERT_EQUAL(MODBUS_DEVICE_FAILURE, write(ARMED, 1, 0)); // not by disarming
    TEST_ASSERT_EQUAL(MODBUS_OK, write(STOP, 1, 0));              // nor by a 0
    TEST_ASSERT_EQUAL(AXIS_RUNNING, axes_get(0)->life.state);
    TEST_ASSERT_EQUAL(false, coil(STOP));
    TEST_ASSERT_EQUAL(MODBUS_OK, write(STOP, 1, 1));
    TEST_ASSERT_EQUAL(true, coil(STOP));
    TEST_ASSERT_EQUAL(false, coil(ARMED));
    bench_rounds(200);
    TEST_ASSERT_EQUAL(false, coil(STOP));
}

static void all_or_none_are_done(void)
{
    load(0);
    load(2);
    // Axis 1 has nothing to arm; the drivers come before.
    TEST_ASSERT_EQUAL(MODBUS_DEVICE_FAILURE, write(DRIVER, 8, 0x7F));
    TEST_ASSERT_EQUAL(false, fake_axes[0].enabled);
    TEST_ASSERT_EQUAL(AXIS_LOADED, axes_get(0)->life.state);
    TEST_ASSERT_EQUAL(MODBUS_OK, write(DRIVER, 8, 0x5F));
    TEST_ASSERT_EQUAL(true, fake_axes[BENCH_LAST].enabled);
    TEST_ASSERT_EQUAL(AXIS_ARMED, axes_get(0)->life.state);
    TEST_ASSERT_EQUAL(AXIS_ARMED, axes_get(BENCH_THIRD)->life.state);
}

// Each axis alone may seek, but not both at once, because only one switch is watched at a time.
static void two_seeks_at_once_are_refused(void)
{
    for (uint8_t i = 0; i < 2; i++) {
        (void)bench_entry(i, LINE_MARK_START | LINE_START_SEEK, 0);
        (void)bench_entry(i, 0, 0);
        (void)bench_entry(i, 1, 1);
        (void)bench_entry(i, 2, 20);
        (void)bench_entry(i, LINE_MARK_DOWN, 0);
        (void)bench_entry(i, 1, 1);
        (void)bench_entry(i, LINE_MARK_END, 0);
        TEST_ASSERT_EQUAL(AXIS_LOADED, axes_get(i)->life.state);
    }
    TEST_ASSERT_EQUAL(MODBUS_DEVICE_FAILURE, write(ARMED, 2, 3));
    TEST_ASSERT_EQUAL(AXIS_LOADED, axes_get(0)->life.state);
    TEST_ASSERT_EQUAL(AXIS_LOADED, axes_get(1)->life.state);
    TEST_ASSERT_EQUAL(MODBUS_OK, write(ARMED, 1, 1));
    TEST_ASSERT_EQUAL(MODBUS_DEVICE_FAILURE, write(ARMED + 1, 1, 1));
}

static void fault_is_read_and_cleared(void)
{
    TEST_ASSERT_EQUAL(false, coil(CLEAR));
    faults_latch(FAULT_starved, 0, 0);
    TEST_ASSERT_EQUAL(true, coil(CLEAR));
    TEST_ASSERT_EQUAL(MODBUS_OK, write(CLEAR, 1, 0));
    TEST_ASSERT_EQUAL(true, coil(CLEAR));
    // Not together with what waits for it.
    TEST_ASSERT_EQUAL(MODBUS_DEVICE_FAILURE, write(CLEAR, 2, 3));
    TEST_ASSERT_EQUAL(true, coil(CLEAR));
    TEST_ASSERT_EQUAL(MODBUS_OK, write(CLEAR, 1, 1));
    TEST_ASSERT_EQUAL(false, coil(CLEAR));
}

static void permit_is_switched_and_read(void)
{
    TEST_ASSERT_EQUAL(false, coil(PERMIT));
    TEST_ASSERT_EQUAL(MODBUS_OK, write(PERMIT, 1, 1));
    TEST_ASSERT_EQUAL(true, coil(PERMIT));
    // Another coil of the same request is impossible: it stays on.
    if (CONFIG_AXES == 4) {
        TEST_ASSERT_EQUAL(MODBUS_DEVICE_FAILURE, write(ARMED, 10, 1));
    }
    TEST_ASSERT_EQUAL(true, coil(PERMIT));
    TEST_ASSERT_EQUAL(MODBUS_OK, write(PERMIT, 1, 0));
    TEST_ASSERT_EQUAL(false, coil(PERMIT));
    faults_latch(FAULT_starved, 0, 0);
    TEST_ASSERT_EQUAL(MODBUS_DEVICE_FAILURE, write(PERMIT, 1, 1));
    TEST_ASSERT_EQUAL(false, coil(PERMIT));
}

// Each bit of a request of two bytes is its own coil's.
static void bits_of_the_second_byte_are_coils_too(void)
{
    TEST_ASSERT_EQUAL(MODBUS_OK, write(DRIVER, BITS_COILS, 1u << PERMIT));
    TEST_ASSERT_EQUAL(true, coil(PERMIT));
    TEST_ASSERT_EQUAL(false, coil(DRIVER));
    TEST_ASSERT_EQUAL(MODBUS_OK, write(DRIVER, BITS_COILS, 0x0Fu));
    TEST_ASSERT_EQUAL(false, coil(PERMIT));
    TEST_ASSERT_EQUAL(true, coil(DRIVER + 3u));
    TEST_ASSERT_EQUAL(MODBUS_OK,
                      write(DRIVER + 1u, BITS_COILS - 1u, 1u << (PERMIT - 1u)));
    TEST_ASSERT_EQUAL(true, coil(PERMIT));
    TEST_ASSERT_EQUAL(true, coil(DRIVER));
    TEST_ASSERT_EQUAL(false, coil(DRIVER + 1u));
    // The stop of the first axis, the lowest bit there.
    load(0);
    TEST_ASSERT_EQUAL(MODBUS_OK, write(ARMED, 1, 1));
    TEST_ASSERT_EQUAL(MODBUS_OK, write(DRIVER, BITS_COILS, 1u << STOP | 0x0Fu));
    TEST_ASSERT_EQUAL(false, coil(ARMED));
}

// A refused request to arm leaves the token alone; an axis that is armed by a coil needs no token.
static void coils_have_no_token(void)
{
    load(0);
    TEST_ASSERT_EQUAL(true, bench_give(1, COMMAND_ARM, 5));
    TEST_ASSERT_EQUAL_UINT16(5, token_now());
    load(1);
    if (CONFIG_AXES == 4) {
        TEST_ASSERT_EQUAL(MODBUS_DEVICE_FAILURE, write(ARMED + 1, 2, 3));
    }
    TEST_ASSERT_EQUAL_UINT16(5, token_now());
    TEST_ASSERT_EQUAL_UINT16(5, commands_last()->argument);
    // The first one would not wait any longer.
    TEST_ASSERT_EQUAL(MODBUS_DEVICE_FAILURE, write(ARMED + 1, 1, 1));
    TEST_ASSERT_EQUAL_UINT16(5, token_now());
    TEST_ASSERT_EQUAL(MODBUS_OK, write(ARMED, 1, 0));
    TEST_ASSERT_EQUAL(MODBUS_OK, write(ARMED + 1, 1, 1));
    TEST_ASSERT_EQUAL_UINT16(0, token_now());
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(as_many_are_mapped_as_there_are);
    RUN_TEST(discrete_inputs_are_two_registers);
    RUN_TEST(drivers_are_switched_and_read);
    RUN_TEST(axes_are_armed_and_disarmed);
    RUN_TEST(running_axis_reads_armed_and_stops);
    if (CONFIG_AXES == 4) {
        RUN_TEST(all_or_none_are_done);
        RUN_TEST(bits_of_the_second_byte_are_coils_too);
    }
    RUN_TEST(two_seeks_at_once_are_refused);
    RUN_TEST(fault_is_read_and_cleared);
    RUN_TEST(permit_is_switched_and_read);
    RUN_TEST(coils_have_no_token);
    return UNITY_END();
}
