// SPDX-License-Identifier: MIT
// Layout of struct wide, for the assembly too; checked in wide.h.
#pragma once

// The lowest byte stands behind the upper four, which are one number.
#define WIDE_LOW 4
