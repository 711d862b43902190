// SPDX-License-Identifier: MIT
#include "app/bits.h"

#include "app/machine.h"       // machine_do, machine_can
#include "base/flash.h"        // IN_FLASH
#include "wire/register_map.h" // REG_INPUT_*
#include "wire/server.h"       // data_*

// Coils in groups: four of an axis each, then single ones.
#define GROUP_DRIVER    0u
#define GROUP_ARMED     1u
#define GROUP_STOP      2u
#define GROUP_SINGLE    3u
#define COIL_SINGLE     12u
#define COIL_PERMIT     13u
#define OUTPUT_PERMIT   8u // bit of input register `outputs`
#define AXIS_OF(coil)   ((coil)&3u)
#define GROUPS          5u

// What 0 and 1 command in each group.
static const char commands[2u * GROUPS] IN_FLASH = {
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

static uint8_t group_of(uint8_t coil)
{
    return coil < COIL_SINGLE ? coil >> 2 : (uint8_t)(coil - COIL_SINGLE + GROUP_SINGLE);
}

bool data_bits_mapped(bool coils, uint16_t address, uint16_t count)
{
    uint8_t limit = coils ? BITS_COILS : BITS_INPUTS;

    if (address >= limit || count > limit - address) {
        return false;
    }
    if (CONFIG_AXES < 4 && coils) {
        for (uint8_t coil = (uint8_t)address; count != 0; coil++, count--) {
            if (coil < COIL_SINGLE && AXIS_OF(coil) >= CONFIG_AXES) {
                return false;
            }
        }
    }
    return true;
}

static bool coil(uint8_t address)
{
    uint8_t axis = AXIS_OF(address);
    uint16_t bits = 0;

    switch (group_of(address)) {
    case GROUP_ARMED:
        return machine_axis(axis)->state == AXIS_ARMED ||
               machine_axis(axis)->state == AXIS_RUNNING;
    case GROUP_STOP:
        bits = machine.stopping;
        break;
    case GROUP_SINGLE:
        return machine.fault.code != FAULT_none;
    case GROUP_DRIVER:
    default:
        bits = data_input(REG_INPUT_outputs);
        axis = address == COIL_PERMIT ? OUTPUT_PERMIT : axis;
        break;
    }
    return (bits >> axis & 1u) != 0;
}

bool data_bit(bool coils, uint16_t address)
{
    if (coils) {
        return coil((uint8_t)address);
    }
    uint16_t word = data_input(address < 16u ? REG_INPUT_status : REG_INPUT_inputs);

    return (word >> (address & 15u) & 1u) != 0;
}

// Every command with all of its axes at once: some are possible for one axis and not for two.
static bool command_all(uint8_t first, uint8_t count, uint16_t bits, bool really)
{
    for (uint8_t i = 0; i < 2u * GROUPS; i++) {
        enum machine_command command = (enum machine_command)flash_char(&commands[i]);
        uint8_t mask = 0;
        uint16_t left = bits;

        for (uint8_t at = first; at < first + count; at++) {
            if (2u * group_of(at) + (left & 1u) == i) {
                mask = (uint8_t)(mask | 1u << AXIS_OF(at));
            }
            left >>= 1;
        }
        if (mask != 0 &&
            !(really ? machine_do(command, mask) : machine_can(command, mask))) {
            return false;
        }
    }
    return true;
}

enum modbus_exception data_write_coils(uint16_t address,
                                       uint16_t count,
                                       const uint8_t *bits)
{
    // Of one coil there is but one byte.
    uint16_t wanted = count > 8u ? (uint16_t)(bits[0] | (uint16_t)bits[1] << 8) : bits[0];

    if (!command_all((uint8_t)address, (uint8_t)count, wanted, false)) {
        return MODBUS_DEVICE_FAILURE;
    }
    (void)command_all((uint8_t)address, (uint8_t)count, wanted, true);
    return MODBUS_OK;
}
