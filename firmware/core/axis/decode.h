// SPDX-License-Identifier: MIT
// The decoder: from an axis's front line to entries of its step ring, as far ahead as the ring has
// room. Each call gets a budget of steps, because the bus and the starts of lines wait while it
// decodes. Main loop only.
//
//     segment --> line.h --> piece --> walk.h --> intervals --> feed.h --> ring entries
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "axis/axis.h" // struct axis

// Decode up to `budget` steps or periods into the ring, as far as there is room. Returns what is
// left of the budget; slow steps take more than one unit of it.
uint8_t decode_axis(struct axis *axis, const struct pixel_period *period, uint8_t budget);

// True when decode_axis() could do nothing now: the ring is full, or the queue is empty.
bool decode_is_ahead(const struct axis *axis);

// Time decoded ahead of the ledger's account, ticks. Inside a pulse train the result is up to one
// tick a step too large.
uint32_t decode_ahead_ticks(const struct axis *axis);
