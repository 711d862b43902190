// SPDX-License-Identifier: MIT
// The addresses of registers.def and of the areas that are arrays rather than named registers.
#pragma once

#define REG_MAP_VERSION 3u

#define REG_AXIS_BASE     0x0020u // per-axis input registers
#define REG_AXIS_STRIDE   0x0010u
#define REG_RECORD_BASE   0x0100u // per-pixel records, input
#define REG_RECORD_STRIDE 0x0080u
#define REG_RECORD_HEADER 4u      // newest pixel (2), count, reserved
#define REG_RECORD_WORDS  6u      // pixel, expected (2), actual (2), clock edge error
#define REG_EVENT_BASE    0x0300u // newest events, input
#define REG_EVENT_HEADER  1u      // events since reset
#define REG_EVENT_WORDS   8u      // number, code, axis, argument, pixel (2), time (2)
#define REG_QUEUE_WINDOW  0x1000u // block, axis, then runs of two words
#define REG_QUEUE_HEADER  2u

#define INPUT(address, name, type, unit, meaning)     REG_INPUT_##name = (address),
#define INPUT_AXIS(offset, name, type, unit, meaning) REG_AXIS_##name = (offset),
#define HOLDING(address, name, type, unit, min, max, initial, meaning)                   \
    REG_HOLDING_##name = (address),
#define COMMAND HOLDING
enum register_address {
#include "wire/registers.def"
};
#undef INPUT
#undef INPUT_AXIS
#undef COMMAND
#undef HOLDING
