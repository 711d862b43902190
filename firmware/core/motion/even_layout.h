// SPDX-License-Identifier: MIT
// Where even_singles.S finds the members of struct even; checked in train_pixel.c. The assembler
// reads this file, too: plain numbers only.
//
// Offsets in bytes.
#pragma once

#define EVEN_BASE      0
#define EVEN_REMAINDER 4
#define EVEN_STEPS     6
#define EVEN_SUM       8
