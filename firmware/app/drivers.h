// SPDX-License-Identifier: MIT
// The motor drivers' enable outputs. A driver is on from a command or from the arming of its axis,
// until a command or until the axis has been at rest for settings.idle_off_ms. Main loop only.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "config.h" // FEATURE_DRIVER_TIMING

// All drivers off; the pins are so already (hal/pins.h).
void drivers_start(void);

// Switch the axis's driver on or off.
void drivers_write(uint8_t axis, bool on);
// The axis's driver is on.
bool drivers_is_on(uint8_t axis);
// Mask of the drivers that are on.
uint8_t drivers_on(void);

#if FEATURE_DRIVER_TIMING

// A driver was switched on less than settings.enable_settle_ms ago: no line may begin yet.
bool drivers_settling(void);

// Switch an idle axis's driver off when its time is over. For one axis after the other.
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
