// SPDX-License-Identifier: MIT
// When the motor drivers are on: from a command or an axis's arming on, until a command or until
// the axis has been at rest for settings.idle_off_ms. Main loop only.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "config.h" // FEATURE_DRIVER_TIMING

// All off; the pins are already so (hal/pins.h).
void drivers_start(void);

void drivers_write(uint8_t axis, bool on);
bool drivers_is_on(uint8_t axis);
uint8_t drivers_on(void); // bit n: that of axis n

#if FEATURE_DRIVER_TIMING

// A driver was switched on less than settings.enable_settle_ms ago: no line may begin yet.
bool drivers_settling(void);

void drivers_poll(uint8_t axis);

#else

static inline bool drivers_settling(void)
{
    return false;
}

static inline void drivers_poll(uint8_t axis)
{
    (void)axis;
}

#endif
