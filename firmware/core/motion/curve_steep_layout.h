// SPDX-License-Identifier: MIT
// Where the assembly (curve_steep_*.S) finds the members of struct curve_steep; checked in
// curve_steep.c. The assembler reads this file, too: plain numbers only.
//
// Offsets in bytes. The limits below are proved beside their use in curve_steep.c.
#pragma once

// Members of struct curve_place at the front.
#define CURVE_STEEP_RESIDUAL 0
#define CURVE_STEEP_SLOPE    5
#define CURVE_STEEP_STEP     10
#define CURVE_STEEP_HALF     16
// The extrapolation, and the sum of a batch.
#define CURVE_STEEP_LAST       18
#define CURVE_STEEP_CHANGE     22
#define CURVE_STEEP_GOOD       27
#define CURVE_STEEP_SUM        28
#define CURVE_STEEP_FIRST_HIGH 31

// A batch goes on while a guess misses by no more than this many ticks,
#define CURVE_STEEP_MISS_MAX 12
// and while the last difference is below this many times 2^32.
#define CURVE_STEEP_LIMIT 0x15
