// SPDX-License-Identifier: MIT
// The decoder: from an axis's front line to entries of its step ring, as far ahead as the ring has
// room. Each call gets a budget, because the bus and the starts of lines wait while it decodes. The
// round (app/round.c) calls the decoder of one axis after the other. Main loop only.
//
//     segment --> line.h --> piece --> walk.h --> intervals --> feed.h --> ring entries
//        |                                                                    ^
//        +--- pixels of even or few curved steps, written as a whole ---------+
//             even_pixel.h, train_pixel.h, curved_pixel.h
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "axis/axis.h" // struct axis

// Decode what `budget` (1..255) pays for into the ring, as far as there is room. A unit is what a
// step of a flat curve costs, about 60 cycles; slow steps and whole pieces take many units, and the
// last of them may take more than is left. period: as axis_arm() had it. Returns what is left of
// the budget: not 0 when the decoder had to end earlier, because the ring, the waypoints, the queue
// or a locked line's clock allowed no more. May begin the next line and change axis->phase.
uint8_t decode_axis(struct axis *axis, const struct pixel_period *period, uint8_t budget);

// True when a call of decode_axis() is not worth its time now: no line is being decoded, the queue
// was empty, fewer entries of the ring are free than a call begins with, both pulse trains are in
// use and one is needed, or the next piece must wait. Changes nothing.
bool decode_is_ahead(const struct axis *axis);

// Time decoded ahead of the ledger's account, ticks. Inside a pulse train the result is up to one
// tick too large for each step of the train that was loaded.
uint32_t decode_ahead_ticks(const struct axis *axis);
