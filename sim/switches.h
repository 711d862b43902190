// SPDX-License-Identifier: MIT
//
// What the home and limit pins of a board saw: the last change of each and, on request, a log of
// all changes. It makes no difference who drives the pin.
//
//   cycle,board,axis,switch,level
//   160000,0,1,home,0          the pin of axis 1's home switch went low in this cycle
//
// Levels are those of the pin: whether 0 means open or closed depends on the plant (active=...).
#pragma once

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "board_pins.h"
#include "own_time.h"
#include "plant.h"
#include "ports.h"

struct switch_state {
    bool level;           // as driven from outside
    uint64_t cycle;       // the bench's, of its last change, 0 if there was none
    uint64_t first_cycle; // of the first edge of that change, before all bouncing
};

struct switches {
    int board; // the board's number in the log
    const struct own_time *time;
    const struct board_kind *kind;
    FILE *log; // cycle,board,axis,switch,level; NULL for none
    struct switch_state state[BOARD_AXES][PLANT_SWITCHES];
    uint8_t on_pin[PORTS_COUNT][8]; // the switch of each pin, from 1 on; 0 for none
};

// Finds the pins of the switches. Call once, with everything zero.
void switches_init(struct switches *switches,
                   const struct board_kind *kind,
                   int board,
                   const struct own_time *time);

// The pin of a switch, NULL if the board has none.
const struct board_pin *switches_pin(const struct switches *switches,
                                     unsigned axis,
                                     enum plant_switch which);

// A pin, of a switch or not, is driven to this level at this cycle. Writes the log.
void switches_pin_driven(
    struct switches *switches, char port, unsigned bit, bool level, uint64_t cycle);
