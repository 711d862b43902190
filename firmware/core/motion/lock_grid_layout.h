// SPDX-License-Identifier: MIT
// Where line_grid_advance.S finds the members of struct line_grid and struct lock_grid; checked in
// lock_grid.c. The assembler reads this file, too: plain numbers only.
//
// Offsets in bytes.
#pragma once

// struct line_grid, and one of its modes.
#define LINE_GRID_MODE        0
#define LINE_GRID_EDGE        1
#define LINE_GRID_EXACT_GRID  3
#define LINE_GRID_REACHED     5
#define LINE_GRID_MODE_LOCKED 2

// struct lock_grid of several axes.
#define LOCK_GRID_NEWEST 45
#define LOCK_GRID_SLACK  53
#define LOCK_GRID_WHOLE  67
#define LOCK_GRID_TIMES  79
