// SPDX-License-Identifier: MIT
// The state of an axis. Only this module writes the state: everybody else reports an event, and the
// table in lifecycle.c gives the next state.
//
//             QUEUED          READY         ARM          PLACED           RELEASED
//      EMPTY --------> LOADING ----> LOADED ----> ARMED --------> STARTING --------> RUNNING
//        ^    READY ....^...............^                                               |
//        |              |               |                                       FINISHED|
//        |              | QUEUED        | READY                                         |
//        |              +---------------+--------------------- DONE <-------------------+
//        | SETTLED
//      STOPPING <--- STOP --- (every state)     EMPTY, LOADING, LOADED, DONE -- REFUSE --> REFUSED
//                                               ARMED, STARTING, RUNNING ------ FAIL ----> FAULT
//
// An event that is not drawn is either forbidden or leaves the state as it is; the table has both.
// Main loop only.
#pragma once

#include <stdbool.h>
#include <stdint.h>

// The numbers of the first eight states are part of the protocol (lifecycle_shown()).
enum axis_state {
    // Nothing is queued.
    AXIS_EMPTY = 0,
    // A line is on its way: too little of it is queued to be armed.
    AXIS_LOADING = 1,
    // A whole line, or as much of a line as fills most of the queue, can be armed.
    AXIS_LOADED = 2,
    // The front line is being decoded ahead, and waits for its place in time.
    AXIS_ARMED = 3,
    // The step interrupt has the line.
    AXIS_RUNNING = 4,
    // The last line ended where it should; nothing is queued.
    AXIS_DONE = 5,
    // A block was refused; the host must discard the axis's lines.
    AXIS_REFUSED = 6,
    // A fault ended the axis's line; the host must clear the fault, which discards the lines.
    AXIS_FAULT = 7,
    // Line zero is known, or needs no edge; the release is near.
    AXIS_STARTING = 8,
    // A stop was requested; the timer still holds a period of the line.
    AXIS_STOPPING = 9,
    // Number of states.
    AXIS_STATES = 10,
};

// What the other modules report, and who does.
enum lifecycle_event {
    // axis.c: a block was queued or a line has ended; what is queued cannot be armed yet.
    LIFECYCLE_QUEUED,
    // axis.c: a block was queued or a line has ended; a line can be armed.
    LIFECYCLE_READY,
    // axis.c: a block was refused.
    LIFECYCLE_REFUSE,
    // axis_arm(): the front line is being decoded ahead.
    LIFECYCLE_ARM,
    // axis_place(): the line has its place in time.
    LIFECYCLE_PLACED,
    // axis_released(): the step interrupt has been given the line.
    LIFECYCLE_RELEASED,
    // axis_line_finished(): the last period of the line was loaded.
    LIFECYCLE_FINISHED,
    // axis_fail(): a fault was latched on this board.
    LIFECYCLE_FAIL,
    // axis_stop(): stop, disarm, discard.
    LIFECYCLE_STOP,
    // axis_discard(): the timer makes idle periods; the queue was discarded.
    LIFECYCLE_SETTLED,
    // Number of events.
    LIFECYCLE_EVENTS,
};

struct lifecycle {
    // enum axis_state; only lifecycle.c writes it.
    uint8_t state;
};

// A new axis: EMPTY.
void lifecycle_reset(struct lifecycle *lifecycle);

// Report an event. Returns true when the event is allowed in this state; the state may stay the
// same all the same. Returns false and changes nothing when the event is forbidden in this state.
bool lifecycle_report(struct lifecycle *lifecycle, enum lifecycle_event event);

// The state as input register axis_state shows it, 0 to 7: STARTING as ARMED, STOPPING as EMPTY.
// Input register `status` shows which axes are stopping.
uint8_t lifecycle_shown(const struct lifecycle *lifecycle);

// True when the axis is armed, with or without a known line zero.
static inline bool lifecycle_armed(const struct lifecycle *lifecycle)
{
    return lifecycle->state == AXIS_ARMED || lifecycle->state == AXIS_STARTING;
}

// True when the axis is armed or running.
static inline bool lifecycle_moving(const struct lifecycle *lifecycle)
{
    return lifecycle->state == AXIS_RUNNING || lifecycle_armed(lifecycle);
}
