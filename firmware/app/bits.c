// SPDX-License-Identifier: MIT
#include "app/bits.h"

#include "app/machine.h"       // machine_do, machine.asking
#include "base/flash.h"        // IN_FLASH
#include "wire/register_map.h" // REG_INPUT_*
#include "wire/server.h"       // data_*

// Coils, as bits of a word: three groups of four, one for each axis, then two single ones.
#define FIRST_ARMED 0x0010u
#define FIRST_STOP  0x0100u
#define CLEAR_FAULT 0x1000u
#define PERMIT      0x2000u
#define MAPPED      (ALL_AXES * (FIRST_STOP + FIRST_ARMED + 1u) | CLEAR_FAULT | PERMIT)

#define OUTPUTS_PERMIT                                                                   \
    0x0100u // bit of input register `outputs`; the drivers are the lowest

#define GROUP_OF(coil) ((coil) < 12u ? (coil) / 4u : (coil) - 9u)

// What 0 and 1 command in each group.
static const char commands[] IN_FLASH = {
    COMMAND_DISABLE,
    COMMAND_ENABLE,
    COMMAND_DISARM,
    COMMAND_ARM,
    COMMAND_NONE,
    COMMAND_STOP,
    COMMAND_NONE,
    COMMAND_CLEAR_FAULT,
    COMMAND_PERMIT_OFF,
    COMMAND_PERMIT_ON,
};

bool data_bits_mapped(uint16_t address, uint16_t count, uint8_t which)
{
    do {
        if (address >= (which == SERVER_COILS ? BITS_COILS : BITS_INPUTS) ||
            (which == SERVER_COILS && (MAPPED >> address & 1u) == 0)) {
            return false;
        }
        address++;
    } while (--count != 0);
    return true;
}

static uint16_t all_coils(void)
{
    uint16_t outputs = data_input(REG_INPUT_outputs);
    uint16_t bits = (uint16_t)((outputs & ALL_AXES) | machine.stopping * FIRST_STOP);

    if ((outputs & OUTPUTS_PERMIT) != 0) {
        bits |= PERMIT;
    }
    if (machine.fault.code != FAULT_none) {
        bits |= CLEAR_FAULT;
    }
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        if (machine_axis(i)->state == AXIS_ARMED ||
            machine_axis(i)->state == AXIS_RUNNING) {
            bits |= (uint16_t)(FIRST_ARMED << i);
        }
    }
    return bits;
}

bool data_bit(uint16_t address, uint8_t which)
{
    uint16_t word = which == SERVER_COILS
                        ? all_coils()
                        : data_input(address < 16u ? REG_INPUT_status : REG_INPUT_inputs);

    return ((uint16_t)(word >> (address & 15u)) & 1u) != 0;
}

// False where one is not possible; those before it are done, or asked about.
static bool command_all(uint8_t coil, uint8_t count, uint16_t values)
{
    do {
        uint8_t which = (uint8_t)(2u * GROUP_OF(coil) + (values & 1u));
        uint8_t axis = CONFIG_AXES == 1 ? 0 : coil % 4u;

        if (!machine_do((enum machine_command)flash_char(&commands[which]),
                        axis_bit(axis))) {
            return false;
        }
        values >>= 1;
        coil++;
    } while (--count != 0);
    return true;
}

enum modbus_exception data_write_coils(uint16_t address,
                                       uint16_t count,
                                       const uint8_t *bits)
{
    // Behind the bits lies at least the checksum.
    uint16_t values = (uint16_t)(bits[0] | (uint16_t)bits[1] << 8);

    uint16_t argument = machine.order[2];
    machine.order[2] = 0; // an axis armed here waits for no token
    machine.asking = MACHINE_ASKS;
    bool possible = command_all((uint8_t)address, (uint8_t)count, values);
    machine.asking = 0;
    if (possible && command_all((uint8_t)address, (uint8_t)count, values)) {
        return MODBUS_OK;
    }
    machine.order[2] = argument;
    return MODBUS_DEVICE_FAILURE;
}
