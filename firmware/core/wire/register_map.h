// SPDX-License-Identifier: MIT
// The addresses of registers.def and of the areas that are arrays rather than named registers.
//
//     input registers                         holding registers
//     0x0000  the board (registers.def)       0x0000  settings (registers.def)
//     0x0020  axis 0, 0x0030 axis 1, ...      0x0100  commands (registers.def)
//     0x0060  more of the board               0x1000  queue window
//     0x0080  free bytes of the queues
//     0x0100  records of axis 0, 0x0180 ...
//     0x0300  event log
//
// docs/PROTOCOL.md says what each register means.
#pragma once

// Input register map_version shows this number, so that a host knows which map a board has.
#define REG_MAP_VERSION 6u

// The input registers of an axis. Register of axis a (from 0):
//
//     REG_AXIS_BASE + a * REG_AXIS_STRIDE + REG_AXIS_name
#define REG_AXIS_BASE   0x0020u
#define REG_AXIS_STRIDE 0x0010u
// The per-pixel records, input registers. Record r of axis a:
//
//     REG_RECORD_BASE + a * REG_RECORD_STRIDE + REG_RECORD_HEADER + r * REG_RECORD_WORDS
//
//     header    newest pixel (2), number of records, records of the line
//     record    pixel, expected position (2), actual position (2), error of the clock's edge
#define REG_RECORD_BASE   0x0100u
#define REG_RECORD_STRIDE 0x0080u
#define REG_RECORD_HEADER 4u
#define REG_RECORD_WORDS  6u
// The newest events, input registers. Event e: REG_EVENT_BASE + REG_EVENT_HEADER
// + e * REG_EVENT_WORDS.
//
//     header    events since reset
//     event     number, code, axis, argument, pixel (2), time (2)
#define REG_EVENT_BASE   0x0300u
#define REG_EVENT_HEADER 1u
#define REG_EVENT_WORDS  8u
// Free bytes in the queue of axis a, input register REG_ROOM_BASE + a. The registers of all axes
// stand together, so that a host that keeps several queues filled reads them by one short request.
#define REG_ROOM_BASE 0x00A0u
// The queue window, holding registers. One write from the window's start carries one block for one
// axis: its number, the axis's word, and then the entries. The axis's word has the number of bytes
// in its high half when packed bytes follow (line/segment_pack.h); else runs of two words follow.
#define REG_QUEUE_WINDOW 0x1000u
#define REG_QUEUE_HEADER 2u

// The rows of registers.def become the constants REG_INPUT_name, REG_AXIS_name (an offset within
// the axis's registers) and REG_HOLDING_name. Commands are holding registers, too.
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
