// SPDX-License-Identifier: MIT
// Reading registers into a reply. Main loop only.
#pragma once

#include <stdbool.h>
#include <stdint.h>

// Read `count` (1..125) mapped input registers, or holding registers, from `address` on,
// big-endian. Returns the place behind them.
uint8_t *read_words(uint8_t *to, uint16_t address, uint8_t count, bool inputs);
