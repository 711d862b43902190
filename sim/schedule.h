// SPDX-License-Identifier: MIT
//
// Events that are scheduled from outside for a board: at a given cycle a pin gets a level, the part
// is reset or its supply changes. Pins change in exactly that cycle, even within an instruction.
// Resets and the supply wait for the end of the instruction in which their cycle falls. A reset of
// the part does not remove events.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include <sim_avr.h>

#include "inputs.h"
#include "own_time.h"
#include "supply.h"

#define SCHEDULE_EVENTS 256 // to come at most

struct scheduled_event {
    uint64_t cycle;              // of the bench; once it is added, of the board
    enum supply_request request; // SUPPLY_REQUEST_NONE: the event drives a pin
    char port;                   // of the pin, 'A' to 'L'
    uint8_t bit;                 // of the pin, 0 to 7
    bool level;                  // of the pin from then on
};

struct schedule {
    avr_t *avr;
    const struct own_time *time;
    struct inputs *inputs;
    struct supply *supply;
    struct scheduled_event event[SCHEDULE_EVENTS]; // in the order of their cycles
    unsigned count;
};

// Connects the schedule with what its events act on. Call once the part exists.
void schedule_attach(struct schedule *schedule,
                     avr_t *avr,
                     const struct own_time *time,
                     struct inputs *inputs,
                     struct supply *supply);

// Schedules an event. Events of the same cycle happen in the order in which they were added; one
// whose cycle the board has passed within its last instruction happens at once. False if
// SCHEDULE_EVENTS are to come.
bool schedule_add(struct schedule *schedule, const struct scheduled_event *event);

// Schedules the first event with libsimavr. Call after a reset, which empties libsimavr's list of
// events.
void schedule_restart(struct schedule *schedule);
