// SPDX-License-Identifier: MIT
// Digital pins by signal name, from the board file.
#pragma once

#include <stdbool.h>
#include <stdint.h>

void pins_write_direction(uint8_t axis, bool negative); // high = negative
void pins_write_enable(uint8_t axis, bool on);          // low = driver on
void pins_write_rs485(bool sending);
void pins_write_permit(bool on);
