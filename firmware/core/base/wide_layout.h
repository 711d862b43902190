// SPDX-License-Identifier: MIT
// Layout of struct wide, for the assembly too; checked in wide.h.
//
//     byte      0     1     2     3     4
//     member   |high, lowest first     |low|
//     weight    2^8   2^16  2^24  2^32  2^0
#pragma once

// The lowest byte stands behind the upper four, which are one number.
#define WIDE_LOW 4
