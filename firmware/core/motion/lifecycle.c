// SPDX-License-Identifier: MIT
#include "motion/lifecycle.h"

#include "base/apart.h" // APART
#include "base/flash.h" // IN_FLASH

// Columns in the order of enum axis_state.
#define EMPTY    AXIS_EMPTY
#define LOADING  AXIS_LOADING
#define LOADED   AXIS_LOADED
#define ARMED    AXIS_ARMED
#define RUNNING  AXIS_RUNNING
#define DONE     AXIS_DONE
#define REFUSED  AXIS_REFUSED
#define FAULT    AXIS_FAULT
#define STARTING AXIS_STARTING
#define STOPPING AXIS_STOPPING
#define NO       AXIS_STATES // the event is forbidden in this state

// clang-format off
static const char next_state[LIFECYCLE_EVENTS][AXIS_STATES] IN_FLASH = {
    //                        EMPTY     LOADING   LOADED    ARMED     RUNNING
    //                        DONE      REFUSED   FAULT     STARTING  STOPPING
    [LIFECYCLE_QUEUED]     = {LOADING,  LOADING,  LOADED,   ARMED,    RUNNING,
                              LOADING,  NO,       NO,       STARTING, NO},
    [LIFECYCLE_READY]      = {LOADED,   LOADED,   LOADED,   ARMED,    RUNNING,
                              LOADED,   NO,       NO,       STARTING, NO},
    [LIFECYCLE_REFUSE]     = {REFUSED,  REFUSED,  REFUSED,  ARMED,    RUNNING,
                              REFUSED,  NO,       NO,       STARTING, NO},
    [LIFECYCLE_ARM]        = {NO,       NO,       ARMED,    NO,       NO,
                              NO,       NO,       NO,       NO,       NO},
    [LIFECYCLE_PLACED]     = {NO,       NO,       NO,       STARTING, NO,
                              NO,       NO,       NO,       NO,       NO},
    [LIFECYCLE_RELEASED]   = {NO,       NO,       NO,       NO,       NO,
                              NO,       NO,       NO,       RUNNING,  NO},
    [LIFECYCLE_FINISHED]   = {NO,       NO,       NO,       NO,       DONE,
                              NO,       NO,       NO,       NO,       NO},
    [LIFECYCLE_FAIL]       = {EMPTY,    LOADING,  LOADED,   FAULT,    FAULT,
                              DONE,     REFUSED,  FAULT,    FAULT,    STOPPING},
    [LIFECYCLE_STOP]       = {STOPPING, STOPPING, STOPPING, STOPPING, STOPPING,
                              STOPPING, STOPPING, STOPPING, STOPPING, STOPPING},
    [LIFECYCLE_SETTLED]    = {NO,       NO,       NO,       NO,       NO,
                              NO,       NO,       NO,       NO,       EMPTY},
};
// clang-format on

void lifecycle_reset(struct lifecycle *lifecycle)
{
    lifecycle->state = AXIS_EMPTY;
}

APART bool lifecycle_report(struct lifecycle *lifecycle, enum lifecycle_event event)
{
    uint8_t to = (uint8_t)flash_char(&next_state[event][lifecycle->state]);

    if (to == NO) {
        return false;
    }
    lifecycle->state = to;
    return true;
}

uint8_t lifecycle_shown(const struct lifecycle *lifecycle)
{
    uint8_t state = lifecycle->state;

    if (state == AXIS_STARTING) {
        return AXIS_ARMED;
    }
    return state == AXIS_STOPPING ? (uint8_t)AXIS_EMPTY : state;
}
