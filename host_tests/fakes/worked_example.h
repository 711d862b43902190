// SPDX-License-Identifier: MIT
// The worked example: a ramp to 1000 steps/pixel, two pixels at that speed,
// the ramp mirrored; with backlash a zero pixel before and after. Positions are the
// anchors.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "line/segment.h" // struct segment

#define WORKED_SPEED      1000u
#define WORKED_RAMP_PX    15u
#define WORKED_ANCHORS_PX 17u

// Counts of the accelerating pixels.
extern const int16_t worked_ramp[WORKED_RAMP_PX];

// Pixels of the line.
uint16_t worked_pixels(uint16_t backlash_steps);

// Entry `index` of the line as it is queued: marks and runs. False behind the last.
bool worked_entry(uint16_t backlash_steps, uint8_t index, struct segment *entry);

// Expected position at the end of pixel 1, 2, ...; backlash 0, 250 or 1000.
int32_t worked_position(uint16_t backlash_steps, uint16_t pixel);
