// SPDX-License-Identifier: MIT
// The motor drivers' enable outputs. A driver is on from a command or from the arming of its axis,
// until a command or until the axis has been at rest for settings.idle_off_ms. Main loop only.
//
//     command, arming   ___/~\_______________________________________
//     ENABLE on         ___/~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~\______
//     axis moves        __________/~~~~~~~~~~~~~\____________________
//                          |------| at least     |------------| idle_off_ms
//                           enable_settle_ms
//
// Both times need FEATURE_DRIVER_TIMING; an image without it leaves drivers on and never waits.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "config.h" // FEATURE_DRIVER_TIMING

// All drivers count as off. The pins are off already (hal/pins.h), so that none is written.
void drivers_start(void);

// Switch the axis's driver on or off. Switching on starts both times of the axis again; they go on
// for a driver that is on already.
void drivers_write_at(uint8_t axis, bool on);

static inline void drivers_write(uint8_t axis, bool on)
{
    drivers_write_at(CONFIG_INDEX(axis), on);
}

// True when the axis's driver is on.
bool drivers_is_on(uint8_t axis);
// Mask of the drivers that are on, bit n for axis n; the low bits of input register `outputs`.
uint8_t drivers_on(void);

#if FEATURE_DRIVER_TIMING

// True when a driver was switched on less than settings.enable_settle_ms ago: no line may begin
// yet. One time for all drivers, counted from the newest switching on.
bool drivers_settling(void);

// Switch the axis's driver off when the axis has been at rest for settings.idle_off_ms (0: never)
// and the last STEP pulse is over. Called for one axis after the other, round by round.
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
