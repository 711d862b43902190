// SPDX-License-Identifier: MIT
// What a host may ask of the board: one table of commands, each with its condition and its act. An
// order is checked as a whole first and done then; a refused one changes nothing. Main loop only.
#pragma once

#include <stdbool.h>
#include <stdint.h>

enum command {
    COMMAND_NONE = 0,
    COMMAND_ARM = 1,
    COMMAND_DISARM = 2,
    COMMAND_STOP = 3,
    COMMAND_CLEAR_FAULT = 4,
    COMMAND_DISCARD = 5,
    COMMAND_ENABLE = 6,
    COMMAND_DISABLE = 7,
    COMMAND_ZERO = 8,
    COMMAND_PERMIT_ON = 9,
    COMMAND_PERMIT_OFF = 10,
    COMMAND_STORE = 11,
    COMMAND_DEFAULTS = 12,
    COMMAND_GO = 13,
    COMMAND_LAST = COMMAND_GO,
};

#define COMMANDS_MASK_MAX 15u
#define COMMANDS_KEY 0x5AFEu // argument of commands that change what outlives a reset

struct order {
    uint16_t mask;     // axes that it is for, 0..COMMANDS_MASK_MAX
    uint16_t command;  // enum command
    uint16_t argument; // arm, go: the token; store, defaults: the key
};

// The order can be carried out now, for every axis that it names.
bool commands_possible(const struct order *order);

// Carry out an order that is possible.
void commands_act(const struct order *order);

// The last order that was carried out.
const struct order *commands_last(void);

// Check, then act and remember. False, and nothing changed, when the order is not possible.
bool commands_give(const struct order *order);
