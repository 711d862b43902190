// SPDX-License-Identifier: MIT
#include "app/registers/bits.h"

#include "app/axes/axes.h"          // axes_get
#include "app/axes/faults.h"        // faults_any
#include "app/registers/commands.h" // commands_*
#include "base/flash.h"             // IN_FLASH
#include "wire/register_map.h"      // REG_INPUT_*
#include "wire/server_data.h"       // data_*

#if FEATURE_BITS

// The coils as bits of a word: three groups (driver, armed, stop) of four coils, one for each axis,
// then two coils of the whole board.
#define FIRST_ARMED 0x0010u
#define FIRST_STOP  0x0100u
#define CLEAR_FAULT 0x1000u
#define PERMIT      0x2000u
#define MAPPED      (ALL_AXES * (FIRST_STOP + FIRST_ARMED + 1u) | CLEAR_FAULT | PERMIT)

#define OUTPUTS_PERMIT                                                                   \
    0x0100u // the permit's bit in input register `outputs`; drivers have the lowest bits

#define GROUPS         5u
#define GROUP_OF(coil) ((coil) < 12u ? (coil) / 4u : (coil) - 9u)

// The commands of a group's coils when 0 and when 1 is written.
static const char coil_commands[] IN_FLASH = {
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
    uint16_t bits = outputs & ALL_AXES;

    if ((outputs & OUTPUTS_PERMIT) != 0) {
        bits |= PERMIT;
    }
    if (faults_any()) {
        bits |= CLEAR_FAULT;
    }
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        const struct lifecycle *life = &axes_get(i)->life;
        if (lifecycle_moving(life)) {
            bits |= (uint16_t)(FIRST_ARMED << i);
        } else if (life->state == AXIS_STOPPING) {
            bits |= (uint16_t)(FIRST_STOP << i);
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

// The orders that a write of coils asks for: one for each command, with its axes.
struct coil_orders {
    uint8_t masks[GROUPS]
                 [2]; // of the coils written 0 and 1; not 0 for a coil without an axis
};

static void collect_orders(struct coil_orders *orders,
                           uint8_t coil,
                           uint8_t count,
                           uint16_t values)
{
    for (; count != 0; count--) {
        uint8_t axis = CONFIG_AXES == 1 ? 0 : coil % 4u;

        orders->masks[GROUP_OF(coil)][values & 1u] |= axis_bit(axis);
        values >>= 1;
        coil++;
    }
}

// Check each order, or execute each order if `act` is set. Returns false when one of the orders is
// not possible.
static bool each_order(const struct coil_orders *orders, bool act)
{
    for (uint8_t i = 0; i < 2u * GROUPS; i++) {
        const struct order order = {
            .mask = orders->masks[i / 2u][i % 2u],
            .command = (uint16_t)flash_char(&coil_commands[i]),
        };
        if (order.mask == 0) {
            continue;
        }
        if (act) {
            commands_act(&order);
        } else if (!commands_possible(&order)) {
            return false;
        }
    }
    return true;
}

// All orders are checked before the first one is executed. The orders have no argument, so that an
// axis that is armed here waits for no token.
enum modbus_exception data_write_coils(uint16_t address,
                                       uint16_t count,
                                       const uint8_t *bits)
{
    // Reading a second byte is safe: at least the checksum lies behind the bits.
    uint16_t values = (uint16_t)(bits[0] | (uint16_t)bits[1] << 8);
    struct coil_orders orders = {0};

    collect_orders(&orders, (uint8_t)address, (uint8_t)count, values);
    if (!each_order(&orders, false)) {
        return MODBUS_DEVICE_FAILURE;
    }
    (void)each_order(&orders, true);
    return MODBUS_OK;
}

#endif
