// SPDX-License-Identifier: MIT
//
// The mechanics of a board's axes: each motor step moves an axis's plant (plant.h); the switches
// that the load presses drive their pins through their contacts (contact.h), each edge in its exact
// cycle.
//
//   rising STEP --> motor --> play --> load --> switch --> contact --> pin
//                     |                  |
//                     +--- plant log ----+
//
// Times are cycles, positions steps. Axes count from 0 up to the board's number of axes.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include <sim_avr.h>

#include "board_pins.h"
#include "contact.h"
#include "inputs.h"
#include "peripheral.h"
#include "plant.h"
#include "plant_log.h"
#include "switches.h"

struct mechanics_axis {
    struct plant plant; // motor, load and the states of the switches
    struct contact contact[PLANT_SWITCHES];
};

struct mechanics {
    avr_t *avr;
    int board; // the board's number in the log
    int axes;
    const struct peripheral_host *host;
    struct inputs *inputs;
    struct switches *switches;
    struct plant_log *log; // NULL for none
    struct mechanics_axis axis[BOARD_AXES];
};

// Connects the mechanics of a board's axes. Call once the part exists. All pointers must stay
// valid.
void mechanics_attach(struct mechanics *mechanics,
                      avr_t *avr,
                      const struct peripheral_host *host,
                      struct inputs *inputs,
                      struct switches *switches);

// Gives an axis its plant; the plant's switches drive their pins from now on.
void mechanics_set_plant(struct mechanics *mechanics,
                         unsigned axis,
                         const struct plant_settings *settings);

// Changes the parameters of an axis's plant while it runs. The contacts are at once what their
// switches then are.
void mechanics_change_plant(struct mechanics *mechanics,
                            unsigned axis,
                            const struct plant_settings *settings);

// The motor makes one step at this cycle: direction +1 or -1. Refuses through the host if a switch
// changes more often within its delay than a contact can remember.
void mechanics_step(struct mechanics *mechanics,
                    unsigned axis,
                    int direction,
                    uint64_t cycle);

// Schedules what the contacts do next. Call after a reset, which empties libsimavr's list of
// events.
void mechanics_schedule(struct mechanics *mechanics);
