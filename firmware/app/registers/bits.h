// SPDX-License-Identifier: MIT
// Coils and discrete inputs. Discrete inputs 0 to 15 are the bits of input register `status`, 16 to
// 31 those of `inputs`. Writing a coil is a command; a coil reads as the state that the command
// changes:
//
//     coil       written 1 (0)            reads 1 while
//     0 to 3     driver of axis n on      the driver is on
//     4 to 7     arm axis n (disarm)      the axis is armed or running
//     8 to 11    stop axis n (nothing)    the axis is stopping
//     12         clear fault (nothing)    a fault is latched
//     13         permit on (off)          the permit output is on
//
// Coils of axes that the board does not have are not mapped. The functions are those of
// wire/server_data.h: data_bits_mapped(), data_bit(), data_write_coils().
//
// A request that writes several coils becomes one order for each command that they ask for. All
// orders are checked before one of them is carried out. An axis that is armed by a coil waits for
// no token.
#pragma once

// Number of discrete inputs.
#define BITS_INPUTS 32u
// Number of coils.
#define BITS_COILS 14u
