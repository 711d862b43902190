// SPDX-License-Identifier: MIT
#include "axis/lifecycle.h"

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
#define NO       0xF // the event is forbidden in this state
_Static_assert(AXIS_STATES <= NO, "a state has four bits");

// What the states become, two in a byte, the lower state in its low bits.
#define BOTH(low, high) (char)((high) << 4 | (low))
#define TO(a, b, c, d, e, f, g, h, i, j)                                                 \
    {BOTH(a, b), BOTH(c, d), BOTH(e, f), BOTH(g, h), BOTH(i, j)}

// clang-format off
static const char next_states[LIFECYCLE_EVENTS][AXIS_STATES / 2] IN_FLASH = {
    //                          EMPTY     LOADING   LOADED    ARMED     RUNNING
    //                          DONE      REFUSED   FAULT     STARTING  STOPPING
    [LIFECYCLE_QUEUED]     = TO(LOADING,  LOADING,  LOADED,   ARMED,    RUNNING,
                                LOADING,  NO,       NO,       STARTING, NO),
    [LIFECYCLE_READY]      = TO(LOADED,   LOADED,   LOADED,   ARMED,    RUNNING,
                                LOADED,   NO,       NO,       STARTING, NO),
    [LIFECYCLE_REFUSE]     = TO(REFUSED,  REFUSED,  REFUSED,  ARMED,    RUNNING,
                                REFUSED,  NO,       NO,       STARTING, NO),
    [LIFECYCLE_ARM]        = TO(NO,       NO,       ARMED,    NO,       NO,
                                NO,       NO,       NO,       NO,       NO),
    [LIFECYCLE_PLACED]     = TO(NO,       NO,       NO,       STARTING, NO,
                                NO,       NO,       NO,       NO,       NO),
    [LIFECYCLE_RELEASED]   = TO(NO,       NO,       NO,       NO,       NO,
                                NO,       NO,       NO,       RUNNING,  NO),
    [LIFECYCLE_FINISHED]   = TO(NO,       NO,       NO,       NO,       DONE,
                                NO,       NO,       NO,       NO,       NO),
    [LIFECYCLE_FAIL]       = TO(EMPTY,    LOADING,  LOADED,   FAULT,    FAULT,
                                DONE,     REFUSED,  FAULT,    FAULT,    STOPPING),
    [LIFECYCLE_STOP]       = TO(STOPPING, STOPPING, STOPPING, STOPPING, STOPPING,
                                STOPPING, STOPPING, STOPPING, STOPPING, STOPPING),
    [LIFECYCLE_SETTLED]    = TO(NO,       NO,       NO,       NO,       NO,
                                NO,       NO,       NO,       NO,       EMPTY),
};
// clang-format on

void lifecycle_reset(struct lifecycle *lifecycle)
{
    lifecycle->state = AXIS_EMPTY;
}

APART bool lifecycle_report(struct lifecycle *lifecycle, enum lifecycle_event event)
{
    uint8_t from = lifecycle->state;
    uint8_t both = (uint8_t)flash_char(&next_states[event][from >> 1]);
    uint8_t to = (from & 1u) != 0 ? (uint8_t)(both >> 4) : (uint8_t)(both & 0xFu);

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
