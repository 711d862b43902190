// SPDX-License-Identifier: MIT
#include "app/motion/parking.h"

#include "app/axes/axes.h"        // axes_*
#include "app/motion/seek.h"      // seek_needs_interrupts
#include "app/watch/time_check.h" // time_check_passes
#include "config.h"               // CONFIG_*
#include "hal/pixel_clock.h"      // pixel_clock_waiting
#include "hal/step_timer.h"       // step_timer_*

#if CONFIG_AXES > 1

static uint8_t looked_at; // the axis to look at next

// True when nothing needs the axis's step interrupt before its next line is released. An armed axis
// that waits for a clock edge may rest too. Edges that were captured while the axis was parked
// before must be placed first.
static bool may_park(uint8_t i)
{
    uint8_t state = axes_get(i)->life.state;

    return state != AXIS_STARTING && state != AXIS_RUNNING && state != AXIS_STOPPING &&
           step_timer_state(i) == STEP_ENGINE_IDLE &&
           !(i == CONFIG_PIXEL_CLOCK_AXIS && pixel_clock_waiting()) &&
           !seek_needs_interrupts(i);
}

void parking_poll(void)
{
    uint8_t i = looked_at;
    const struct ledger *ledger = &axes_get(i)->ledger;

    looked_at = (uint8_t)((i + 1u) % CONFIG_AXES);
    if (may_park(i) && time_check_passes(i) && axes_advance(i, LEDGER_EXACTLY) &&
        ledger_idles(ledger)) {
        (void)step_timer_park(i, ledger->idle_seen);
    }
}

#endif
