// SPDX-License-Identifier: MIT
// Where curve_steep_fit.S finds the members of struct curve_steep; checked in curve_steep.c. Plain
// numbers: read by the assembler too.
#pragma once

#define CURVE_STEEP_RESIDUAL 0
#define CURVE_STEEP_SLOPE    5
#define CURVE_STEEP_STEP     10
#define CURVE_STEEP_HALF     16

// struct wide: the upper four bytes, then the lowest.
#define CURVE_STEEP_WIDE_LOW 4
