// SPDX-License-Identifier: MIT
// Digital outputs by the names of their signals; the board file assigns the pins. Each function may
// be called with interrupts on or off.
#pragma once

#include <stdbool.h>
#include <stdint.h>

// High: negative direction.
void pins_write_direction(uint8_t axis, bool negative);
// Low: driver on.
void pins_write_enable(uint8_t axis, bool on);
// High: the bus driver sends.
void pins_write_rs485(bool sending);
// High: permit on.
void pins_write_permit(bool on);
