// SPDX-License-Identifier: MIT
//
// The mechanics of one axis: motor steps move a load through play, between hard stops, past limit
// and home switches. Lengths are in steps, times in ticks (cycles).
//
//   hard stop   limit-            home (closed above it)             limit+   hard stop
//   ----|----------|------------------|-----------------------------------|----------|----
//       travel_min - over             home                       travel_max + over
//
//   load's position --> switch --> stuck? --> contact: delay, bounce (contact.h) --> pin
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "contact.h"

enum plant_switch { PLANT_HOME, PLANT_LIMIT_MINUS, PLANT_LIMIT_PLUS, PLANT_SWITCHES };

enum plant_stuck { STUCK_FREE, STUCK_OPEN, STUCK_CLOSED };

struct plant_settings {
    bool present; // the axis was given parameters: its switches drive their pins
    bool has_travel, has_home; // the axis has these switches
    bool has_start, has_seed;  // these were among the parameters
    bool taken_up_minus; // the motor starts the play below the load, not where it is
    bool active_high; // a closed switch reads 1 (default: 0, to ground, with the pull-up)
    struct contact_settings contact;
    enum plant_stuck stuck[PLANT_SWITCHES];
    int64_t play;                   // between motor and load
    int64_t travel_min, travel_max; // limit switches close at and beyond these
    int64_t over; // from a limit to its hard stop; steps beyond it are lost
    int64_t home, home_hysteresis; // closes at home, opens at home - hysteresis
    int64_t start;                 // the load is here at the start, or is put here later
    uint64_t seed;                 // of the bouncing
};

struct plant {
    struct plant_settings settings;
    int64_t motor, load;
    int64_t lost_steps;
    bool pressed_home;           // by the load's position, whether it is stuck or not
    bool closed[PLANT_SWITCHES]; // the states that the contacts follow
};

// Puts the load at `start`, the play taken up as the settings say, the motor accordingly.
void plant_init(struct plant *plant, const struct plant_settings *settings);

// Changes the parameters while the axis moves. Motor and load stay where they are, unless `start`
// is among the parameters.
void plant_change(struct plant *plant, const struct plant_settings *settings);

// True if the axis has this switch.
bool plant_has(const struct plant *plant, enum plant_switch which);

// Moves the motor by one step, +1 or -1. A step against a hard stop is lost: motor and load stay.
// Returns true if a switch has changed.
bool plant_step(struct plant *plant, int direction);

// The switch's name in parameters and logs: "home", "minus" or "plus".
const char *plant_switch_name(enum plant_switch which);
