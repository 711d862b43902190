// SPDX-License-Identifier: MIT
// Where pixel_grid_advance.S finds the members of struct pixel_period and struct pixel_grid;
// checked in pixel_period.c. The assembler reads this file, too: plain numbers only.
//
// Offsets in bytes.
#pragma once

// struct pixel_period.
#define PIXEL_PERIOD_WHOLE     0
#define PIXEL_PERIOD_REMAINDER 4
#define PIXEL_PERIOD_DIVISOR   8

// struct pixel_grid.
#define PIXEL_GRID_PERIOD 0
#define PIXEL_GRID_SUM    2
