// SPDX-License-Identifier: MIT
// The commands of a host: one table with the condition and the action of each. An order (a command
// with its axes and its argument) is checked as a whole before any part of it is carried out; a
// refused order moves, queues and switches nothing. Registers and coils use the same table. Main
// loop only.
//
//     order --> commands_possible(), for every axis --> commands_act(), for every axis
//                      |
//                      +--> no: exception reply, nothing is carried out
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "build_features.h" // FEATURE_GATE

enum command {
    // Nothing; always possible.
    COMMAND_NONE = 0,
    // Decode the front line ahead; with an argument, wait for that token.
    COMMAND_ARM = 1,
    // Disarm axes and discard their lines; none of them may run or be in FAULT.
    COMMAND_DISARM = 2,
    // End motion at once and discard what is queued; the permit goes off.
    COMMAND_STOP = 3,
    // Forget the latched faults and discard the lines of axes in FAULT; every axis must be at rest.
    COMMAND_CLEAR_FAULT = 4,
    // Discard the axes' lines; none of them may run or be in FAULT.
    COMMAND_DISCARD = 5,
    // Switch drivers on.
    COMMAND_ENABLE = 6,
    // Switch drivers off; each axis must be at rest, unarmed and not in FAULT.
    COMMAND_DISABLE = 7,
    // Make the place of the captured home switch's edge position 0.
    COMMAND_ZERO = 8,
    // Switch the permit output on; no fault and no emergency stop may be latched.
    COMMAND_PERMIT_ON = 9,
    // Switch the permit output off.
    COMMAND_PERMIT_OFF = 10,
    // Store the settings. Needs the key; no line may be queued, no record be on its way.
    COMMAND_STORE = 11,
    // Replace the settings by the defaults, under the same conditions.
    COMMAND_DEFAULTS = 12,
    // Release the axes that wait for this token; another token is a fault. Lines that wait for the
    // pixel clock begin on the edge that the order names.
    COMMAND_GO = 13,
    // Note which clock edge was the newest one when this command ended.
    COMMAND_MARK = 14,
    // The largest code.
    COMMAND_LAST = COMMAND_MARK,
};

// Largest axis mask of an order.
#define COMMANDS_MASK_MAX 15u
// Argument that commands need when they change what outlives a reset.
#define COMMANDS_KEY 0x5AFEu

// The five words of registers.def from axis_mask on, in their order.
struct order {
    // Axes that the order is for, 0..COMMANDS_MASK_MAX.
    uint16_t mask;
    // enum command.
    uint16_t command;
    // Arm, go: the token. Store, defaults: the key.
    uint16_t argument;
    // Go: the number of the clock edge that is line zero, 0 none.
    uint16_t edge;
    // Whose job the board is in, 0 after a reset: no order changes it, a host that writes it does.
    uint16_t tag;
};

// True when the order can be carried out now, for every axis that it names. The order's command
// must be COMMAND_LAST at most; disarm and stop may name axes that the board does not have. Changes
// nothing.
bool commands_possible(const struct order *order);

// Carry out an order for which commands_possible() was true just now.
void commands_act(const struct order *order);

// The last order that commands_give() carried out; all 0 after a reset.
const struct order *commands_last(void);

// Check an order, then carry it out and remember it. Returns false when the order is not possible.
// Nothing was carried out then. One thing changes: an arming that would be too fast for the axes
// that move together writes the reason into line_error of the first axis that is too fast.
bool commands_give(const struct order *order);

#if FEATURE_GATE
// Arm the axis's front line, whose line before is done, if the line can be armed now. A clock edge
// that is named stays named.
void commands_arm_next(uint8_t axis);
#else
static inline void commands_arm_next(uint8_t axis)
{
    (void)axis;
}
#endif
