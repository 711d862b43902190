// SPDX-License-Identifier: MIT
// Digital outputs by the names of their signals; the board file assigns the pins. Each function may
// be called with interrupts on or off.
//
//     signal       low               high
//     DIR          positive          negative
//     ENABLE       driver on         driver off
//     RS485_DE     receive           send
//     PERMIT       off               on
#pragma once

#include <stdbool.h>
#include <stdint.h>

// Set DIR of an axis. High: negative direction. Called in the step interrupt, and in the main loop
// while the axis is at rest.
void pins_write_direction(uint8_t axis, bool negative);
// Set ENABLE of an axis, low for on.
void pins_write_enable(uint8_t axis, bool on);
// Set the direction of the RS-485 driver, high while the board sends.
void pins_write_rs485(bool sending);
// Set PERMIT, high for on. It knows nothing of the emergency stop: hal/estop.h decides.
void pins_write_permit(bool on);
