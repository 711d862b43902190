// SPDX-License-Identifier: MIT
// The state of an axis. Only this module writes the state: everybody else reports an event, and the
// table in lifecycle.c gives the next state.
//
//             QUEUED          READY         ARM          PLACED           RELEASED
//      EMPTY --------> LOADING ----> LOADED ----> ARMED --------> STARTING --------> RUNNING
//        ^    READY ....................^ ^                                             |
//        |                                |  QUEUED, READY                      FINISHED|
//        |                                +------------------- DONE <-------------------+
//        | SETTLED
//      STOPPING <--- STOP --- (every state)     EMPTY, LOADING, LOADED, DONE -- REFUSE --> REFUSED
//                                               ARMED, STARTING, RUNNING ------ FAIL ----> FAULT
//
// An event that is not drawn is either forbidden or leaves the state as it is; the table has both.
// Main loop only.
#pragma once

#include <stdbool.h>
#include <stdint.h>

enum axis_state {
    AXIS_EMPTY = 0,   // nothing queued
    AXIS_LOADING = 1, // a line is on its way
    AXIS_LOADED = 2,  // a whole line, or as much as the memory holds, can be armed
    AXIS_ARMED = 3,   // decoded ahead; waits for a pixel clock edge
    AXIS_RUNNING = 4,
    AXIS_DONE = 5,     // the last line ended where it should; nothing queued
    AXIS_REFUSED = 6,  // a block was refused; discard to recover
    AXIS_FAULT = 7,    // stopped by a fault; clear the fault to recover
    AXIS_STARTING = 8, // line zero is known (or needs no edge); the release is near
    // A stop was requested; the timer still holds a period of the line.
    AXIS_STOPPING = 9,
    AXIS_STATES = 10,
};

enum lifecycle_event {
    LIFECYCLE_QUEUED,   // a block was queued; the line is not complete yet
    LIFECYCLE_READY,    // a block was queued; a line can be armed
    LIFECYCLE_REFUSE,   // a block was refused
    LIFECYCLE_ARM,      // the front line is being decoded ahead
    LIFECYCLE_PLACED,   // the line has its place in time
    LIFECYCLE_RELEASED, // the step interrupt has been given the line
    LIFECYCLE_FINISHED, // the last period of the line was loaded
    LIFECYCLE_FAIL,     // a fault was latched on this board
    LIFECYCLE_STOP,     // stop, disarm, discard
    LIFECYCLE_SETTLED,  // the timer makes idle periods; the queue was discarded
    LIFECYCLE_EVENTS,
};

struct lifecycle {
    // enum axis_state; only lifecycle.c writes it.
    uint8_t state;
};

// A new axis: EMPTY.
void lifecycle_reset(struct lifecycle *lifecycle);

// Report an event. Returns false and changes nothing when the event is forbidden in this state.
bool lifecycle_report(struct lifecycle *lifecycle, enum lifecycle_event event);

// The state as input register axis_state shows it, 0 to 7: STARTING as ARMED, STOPPING as EMPTY.
// Input register `status` shows which axes are stopping.
uint8_t lifecycle_shown(const struct lifecycle *lifecycle);

// The axis is armed, with or without a known line zero.
static inline bool lifecycle_armed(const struct lifecycle *lifecycle)
{
    return lifecycle->state == AXIS_ARMED || lifecycle->state == AXIS_STARTING;
}

// The axis is armed or running.
static inline bool lifecycle_moving(const struct lifecycle *lifecycle)
{
    return lifecycle->state == AXIS_RUNNING || lifecycle_armed(lifecycle);
}
