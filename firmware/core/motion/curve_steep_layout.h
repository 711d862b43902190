// SPDX-License-Identifier: MIT
// Where curve_steep_fit.S finds the members of struct curve_steep; checked in curve_steep.c. Plain
// numbers: read by the assembler too.
#pragma once

#define CURVE_STEEP_RESIDUAL   0
#define CURVE_STEEP_SLOPE      5
#define CURVE_STEEP_STEP       10
#define CURVE_STEEP_HALF       16
#define CURVE_STEEP_LAST       18
#define CURVE_STEEP_CHANGE     22
#define CURVE_STEEP_GOOD       27
#define CURVE_STEEP_SUM        28
#define CURVE_STEEP_FIRST_HIGH 31

// struct wide: the upper four bytes, then the lowest.
#define CURVE_STEEP_WIDE_LOW 4

// A batch goes on while the guesses miss by no more than so many ticks,
#define CURVE_STEEP_MISS_MAX 12
// and the last difference is below so many times 2^32.
#define CURVE_STEEP_LIMIT 0x15
