// SPDX-License-Identifier: MIT
// Where the simulator's test images leave what they have seen: words at a fixed address, which the
// test reads with `peek`. The address is RAM on both parts and far from variables and stack.
#pragma once

#include <stdint.h>

#define RESULT_ADDRESS 0x600
#define RESULT         ((volatile uint16_t *)RESULT_ADDRESS)
