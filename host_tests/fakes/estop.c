// SPDX-License-Identifier: MIT
// A fake of hal/estop.h: a suite sets the level. There is no noise, so that one look is enough.
#include "hal/estop.h"

#include "fakes/board.h"
#include "fakes/board_parts.h"
#include "hal/step_timer.h"

bool fake_permit;
static bool level;
static bool high_trips;
static bool latched;
static bool tripped_before;

void fake_estop_power_on(void)
{
    level = true;
    high_trips = false;
    latched = false;
    tripped_before = false;
    fake_permit = false;
}

static void stop_all(void)
{
    latched = true;
    fake_permit = false;
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        step_timer_halt(i);
    }
}

void fake_estop(bool high)
{
    bool changed = level != high;

    level = high;
    if (changed && estop_tripped()) {
        stop_all();
    }
}

void estop_start(bool tripped_high)
{
    high_trips = tripped_high;
}

void estop_poll(bool tripped_high)
{
    high_trips = tripped_high;
    bool tripped = estop_tripped();

    if (latched || (tripped && tripped_before)) {
        stop_all();
    }
    tripped_before = tripped;
}

bool estop_tripped(void)
{
    return level == high_trips;
}

bool estop_latched(void)
{
    return latched;
}

void estop_release(void)
{
    latched = false;
}

void permit_write(bool on)
{
    fake_permit = on && !latched;
}
