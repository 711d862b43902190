// SPDX-License-Identifier: MIT
// The commands of a host: one table with the condition and the action of each. An order (a command
// with its axes and its argument) is checked as a whole before any part of it is carried out; a
// refused order changes nothing. Registers and coils use the same table. Main loop only.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "build_features.h" // FEATURE_GATE

enum command {
    COMMAND_NONE = 0,
    // Decode the front line ahead; with an argument, wait for that token.
    COMMAND_ARM = 1,
    // Disarm axes and discard their lines; none of them may run.
    COMMAND_DISARM = 2,
    // End motion at once and discard what is queued; the permit goes off.
    COMMAND_STOP = 3,
    // Forget the latched faults; every axis must be at rest.
    COMMAND_CLEAR_FAULT = 4,
    // Discard the axes' lines; none of them may run.
    COMMAND_DISCARD = 5,
    // Switch drivers on or off; off needs an axis at rest.
    COMMAND_ENABLE = 6,
    COMMAND_DISABLE = 7,
    // Make the place of the captured home switch's edge position 0.
    COMMAND_ZERO = 8,
    // Switch the permit output on or off.
    COMMAND_PERMIT_ON = 9,
    COMMAND_PERMIT_OFF = 10,
    // Store the settings, or replace them by the defaults; both need the key.
    COMMAND_STORE = 11,
    COMMAND_DEFAULTS = 12,
    // Release the axes that wait for this token; another token is a fault. Lines that wait for the
    // pixel clock begin on the edge that the order names.
    COMMAND_GO = 13,
    // Note which clock edge was the newest one when this command ended.
    COMMAND_MARK = 14,
    COMMAND_LAST = COMMAND_MARK,
};

// Largest axis mask of an order.
#define COMMANDS_MASK_MAX 15u
// Argument that commands need when they change what outlives a reset.
#define COMMANDS_KEY 0x5AFEu

// The four words of registers.def from axis_mask on, in their order.
struct order {
    // Axes that the order is for, 0..COMMANDS_MASK_MAX.
    uint16_t mask;
    // enum command.
    uint16_t command;
    // Arm, go: the token. Store, defaults: the key.
    uint16_t argument;
    // Go: the number of the clock edge that is line zero, 0 none.
    uint16_t edge;
};

// True when the order can be carried out now, for every axis that it names.
bool commands_possible(const struct order *order);

// Carry out an order that is possible.
void commands_act(const struct order *order);

// The last order that commands_give() carried out.
const struct order *commands_last(void);

// Check an order, then carry it out and remember it. Returns false and changes nothing when the
// order is not possible.
bool commands_give(const struct order *order);

#if FEATURE_GATE
// Arm the axis's front line, whose line before is done, if the line can be armed now. Nothing else
// changes: a clock edge that is named stays so.
void commands_arm_next(uint8_t axis);
#else
static inline void commands_arm_next(uint8_t axis)
{
    (void)axis;
}
#endif
