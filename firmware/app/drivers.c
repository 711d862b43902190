// SPDX-License-Identifier: MIT
#include "app/drivers.h"

#include "app/machine.h"    // machine_axis
#include "hal/clock.h"      // clock_now_ms
#include "hal/step_timer.h" // step_timer_enable

// STEP of the last period is high for up to 4.1 ms, and an axis may have been looked at a few
// rounds ago.
#define LAST_STEP_MS 15u

bool drivers_is_on(uint8_t axis)
{
    return (machine.drivers.on & axis_bit(axis)) != 0;
}

void drivers_write(uint8_t axis, bool on)
{
    if (on && !drivers_is_on(axis)) {
        machine.drivers.switched_ms = clock_now_ms();
        machine.drivers.moved_ms[CONFIG_INDEX(axis)] = machine.drivers.switched_ms;
        machine.drivers.settling = true;
    }
    machine.drivers.on = (uint8_t)(on ? machine.drivers.on | axis_bit(axis)
                                      : machine.drivers.on & ~axis_bit(axis));
    step_timer_enable(axis, on);
}

bool drivers_settling(void)
{
    machine.drivers.settling = machine.drivers.settling &&
                               (uint16_t)(clock_now_ms() - machine.drivers.switched_ms) <=
                                   machine.settings.enable_settle_ms;
    return machine.drivers.settling;
}

void drivers_poll(uint8_t axis)
{
    uint16_t idle_ms = machine.settings.idle_off_ms;
    uint16_t *moved_ms = &machine.drivers.moved_ms[CONFIG_INDEX(axis)];
    uint8_t state = machine_axis(axis)->state;

    if (state == AXIS_ARMED || state == AXIS_RUNNING ||
        step_engine_going(step_timer_state(axis))) {
        *moved_ms = clock_now_ms();
    } else if (idle_ms != 0 && drivers_is_on(axis) &&
               (uint16_t)(clock_now_ms() - *moved_ms) > idle_ms + LAST_STEP_MS) {
        drivers_write(axis, false);
    }
}
