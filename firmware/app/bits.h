// SPDX-License-Identifier: MIT
// Discrete inputs and coils. Inputs 0 to 15 are the bits of input register `status`, 16 to 31 those
// of `inputs`. Writing a coil is a command, and reads back what became of it: 0 to 3 driver of axis
// n, 4 to 7 axis n armed (or running), 8 to 11 stop axis n (1 while it stops), 12 clear fault (1
// while one is latched), 13 permit output. Coils of axes that the board does not have are not
// mapped. The functions are those that wire/server.h asks for: data_bits_mapped(), data_bit(),
// data_write_coils().
#pragma once

#define BITS_INPUTS 32u
#define BITS_COILS  14u
