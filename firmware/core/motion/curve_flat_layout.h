// SPDX-License-Identifier: MIT
// Where curve_flat_steps.S finds the members of struct curve_flat; checked in curve_flat.c. The
// assembler reads this file, too: plain numbers only.
//
// Offsets in bytes; a struct wide takes 5.
#pragma once

// The four numbers of 40 bits, in the order of the struct.
#define CURVE_FLAT_RESIDUAL    0
#define CURVE_FLAT_GAIN        5
#define CURVE_FLAT_DIFFERENCE  10
#define CURVE_FLAT_GAIN_GROWTH 15
// Numbers of 32, 16 and 16 bits.
#define CURVE_FLAT_SLOPE_GROWTH 20
#define CURVE_FLAT_TWICE_HALF   24
#define CURVE_FLAT_TOP          26
