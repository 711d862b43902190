// SPDX-License-Identifier: MIT
// When the motor drivers are on: from a command or an axis's arming on, until a command or until
// the axis has been at rest for settings.idle_off_ms. Main loop only.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "config.h" // CONFIG_AXES

struct drivers {
    uint8_t on;                     // bit n: that of axis n
    bool settling;                  // one was switched on lately
    uint16_t switched_ms;           // when that was
    uint16_t moved_ms[CONFIG_AXES]; // when each axis was last seen moving or switched on
};

void drivers_write(uint8_t axis, bool on);
bool drivers_is_on(uint8_t axis);

// A driver was switched on less than settings.enable_settle_ms ago: no line may begin yet.
bool drivers_settling(void);

void drivers_poll(uint8_t axis);
