// SPDX-License-Identifier: MIT
// The decoder: from an axis's front line to entries of its step ring, as far ahead as the ring has
// room. A round of decoding takes a budget of steps, because the bus and the starts of lines wait
// for it. Main loop only.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "motion/axis.h" // struct axis

// Decode up to `budget` steps or periods into the ring, as far as there is space. Returns what is
// left of the budget: slow steps take more of it.
uint8_t decode_axis(struct axis *axis,
                    const struct pixel_period *period,
                    bool always_take_up,
                    uint8_t budget);

// True when decode_axis() has nothing it could do now.
bool decode_is_ahead(const struct axis *axis);

// Time decoded ahead of the interrupt, ticks; inside a run up to a tick a step too much.
uint32_t decode_ahead_ticks(const struct axis *axis);
