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
#define ALL_AXES    ((1u << CONFIG_AXES) - 1u)
#define MAPPED      (ALL_AXES * (FIRST_STOP + FIRST_ARMED + 1u) | CLEAR_FAULT | PERMIT)

#define OUTPUTS_PERMIT 0x0100u // bit of input register `outputs`; the drivers are the lowest

// What 0 and 1 command in each group: the group's first bit, and the command.
#define COMMAND_OF(first, command) (char)((first) << 4 | (command))
static const char commands[] IN_FLASH = {
    COMMAND_OF(0, COMMAND_DISABLE),
    COMMAND_OF(0, COMMAND_ENABLE),
    COMMAND_OF(4, COMMAND_DISARM),
    COMMAND_OF(4, COMMAND_ARM),
    COMMAND_OF(8, COMMAND_NONE),
    COMMAND_OF(8, COMMAND_STOP),
    COMMAND_OF(12, COMMAND_NONE),
    COMMAND_OF(12, COMMAND_CLEAR_FAULT),
    COMMAND_OF(13, COMMAND_PERMIT_OFF),
    COMMAND_OF(13, COMMAND_PERMIT_ON),
};
#define SINGLE 0xC0u // from here on a group is one bit

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
    uint16_t word =
        which == SERVER_COILS
            ? all_coils()
            : data_input(address < 16u ? REG_INPUT_status : REG_INPUT_inputs);

    return (word >> (address & 15u) & 1u) != 0;
}

// One group after the other, each command with all of its axes at once: some are possible for one
// axis and not for two. False where one is not possible.
static bool command_all(uint16_t off, uint16_t on)
{
    for (uint8_t i = 0; i < sizeof commands; i++) {
        uint8_t entry = (uint8_t)flash_char(&commands[i]);
        uint16_t bits = (i & 1u) == 0 ? off : on;
        uint8_t mask =
            (uint8_t)(bits >> (entry >> 4) & (entry < SINGLE ? ALL_AXES : 1u));

        if (mask != 0 && !machine_do((enum machine_command)(entry & 15u), mask)) {
            return false;
        }
    }
    return true;
}

enum modbus_exception data_write_coils(uint16_t address,
                                       uint16_t count,
                                       const uint8_t *bits)
{
    // Behind the bits lies at least the checksum.
    uint16_t values = (uint16_t)(bits[0] | (uint16_t)bits[1] << 8);
    uint16_t place = (uint16_t)(1u << address);
    uint16_t off = 0;
    uint16_t on = 0;

    do {
        if ((values & 1u) == 0) {
            off |= place;
        } else {
            on |= place;
        }
        values >>= 1;
        place = (uint16_t)(place << 1);
    } while (--count != 0);
    machine.asking = true;
    bool possible = command_all(off, on);
    machine.asking = false;
    machine.order[2] = 0; // an axis armed here waits for no token
    return possible && command_all(off, on) ? MODBUS_OK : MODBUS_DEVICE_FAILURE;
}
