// SPDX-License-Identifier: MIT
#include "app/watch/drivers.h"

#include "app/axes/axes.h"         // axes_get
#include "app/settings/settings.h" // settings_now
#include "hal/clock.h"             // clock_now_ms
#include "hal/step_timer.h"        // step_timer_enable

// A driver stays on for this long after its axis was last seen moving: STEP of the last period is
// high for up to 4.1 ms, and the axis may have been seen only a few rounds ago.
#define LAST_STEP_MS 15u

static struct {
    uint8_t on; // bit n: the driver of axis n is on
#if FEATURE_DRIVER_TIMING
    bool settling;                  // a driver was switched on lately
    uint16_t switched_ms;           // time at which that driver was switched on
    uint16_t moved_ms[CONFIG_AXES]; // time of each axis's last movement or switching on
#endif
} drivers;

void drivers_start(void)
{
    drivers.on = 0;
#if FEATURE_DRIVER_TIMING
    drivers.settling = false;
#endif
}

uint8_t drivers_on(void)
{
    return drivers.on;
}

bool drivers_is_on(uint8_t axis)
{
    return (drivers.on & axis_bit(axis)) != 0;
}

void drivers_write_at(uint8_t axis, bool on)
{
#if FEATURE_DRIVER_TIMING
    if (on && !drivers_is_on(axis)) {
        drivers.switched_ms = clock_now_ms();
        drivers.moved_ms[CONFIG_INDEX(axis)] = drivers.switched_ms;
        drivers.settling = true;
    }
#endif
    drivers.on =
        (uint8_t)(on ? drivers.on | axis_bit(axis) : drivers.on & ~axis_bit(axis));
    step_timer_enable(axis, on);
}

#if FEATURE_DRIVER_TIMING

bool drivers_settling(void)
{
    drivers.settling =
        drivers.settling && (uint16_t)(clock_now_ms() - drivers.switched_ms) <=
                                settings_now()->enable_settle_ms;
    return drivers.settling;
}

void drivers_poll(uint8_t axis)
{
    uint16_t idle_ms = settings_now()->idle_off_ms;
    uint16_t *moved_ms = &drivers.moved_ms[CONFIG_INDEX(axis)];
    uint16_t now_ms = clock_now_ms();

    if (lifecycle_moving(&axes_get(axis)->life) ||
        step_engine_going(step_timer_state(axis))) {
        *moved_ms = now_ms;
    } else if (idle_ms != 0 && drivers_is_on(axis) &&
               (uint16_t)(now_ms - *moved_ms) > idle_ms + LAST_STEP_MS) {
        drivers_write(axis, false);
    }
}

#endif
