// SPDX-License-Identifier: MIT
// This file is MIT; the program it is linked into is GPL-3.0 as a whole, because of libsimavr.
//
// The mechanics of one axis: motor steps move a load through play, between hard stops, past limit
// and home switches. All lengths in steps.
//
//   hard stop   limit-            home (closed above it)             limit+   hard stop
//   ----|----------|------------------|-----------------------------------|----------|----
//       travel_min - over             home                       travel_max + over
#pragma once

#include <stdbool.h>
#include <stdint.h>

struct plant_settings {
    bool present; // --plant was given for this axis: its switches drive their pins
    int64_t play; // between motor and load
    bool has_travel;
    int64_t travel_min, travel_max; // limit switches close at and beyond these
    int64_t over; // from a limit to its hard stop; steps beyond it are lost
    bool has_home;
    int64_t home, home_hysteresis; // closes at home, opens at home - hysteresis
    int64_t start;                 // where motor and load are at reset
    bool active_high; // a closed switch reads 1 (default: 0, to ground, with the pull-up)
};

enum plant_switch { PLANT_HOME, PLANT_LIMIT_MINUS, PLANT_LIMIT_PLUS, PLANT_SWITCHES };

struct plant {
    struct plant_settings settings;
    int64_t motor, load;
    int64_t lost_steps;
    bool closed[PLANT_SWITCHES];
};

void plant_init(struct plant *plant, const struct plant_settings *settings);

// One motor step, +1 or -1. Returns true if a switch has changed.
bool plant_step(struct plant *plant, int direction);

// Reads "play=40,travel=-100..9000,over=50,home=0,hyst=8,start=0,active=low" into the settings;
// on an error returns the word it cannot make sense of, else NULL. Changes the text.
const char *plant_parse(struct plant_settings *settings, char *text);
