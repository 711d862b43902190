// SPDX-License-Identifier: MIT
// Reading registers into a reply, whatever function asks for them: by its words, or as a file. Main
// loop only.
//
//     server.c, files.c ---- read_words() ----> data_inputs(), data_input(), data_holding()
//
// Where there are several axes, registers that take less time together are read together.
#pragma once

#include <stdbool.h>
#include <stdint.h>

// Read `count` (0..125) mapped input registers (inputs: true) or holding registers from `address`
// on, big-endian. The caller has checked that the registers exist and that 2 * count bytes fit.
// Returns the place after them. On boards of several axes there may be interludes.
uint8_t *read_words(uint8_t *to, uint16_t address, uint8_t count, bool inputs);
