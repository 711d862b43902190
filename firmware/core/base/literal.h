// SPDX-License-Identifier: MIT
// A number that is unsigned in C, in headers that the assembler reads too (ring/step_codes.h): the
// assembler knows no suffixes. number: digits, decimal or hexadecimal, without a suffix.
//
//     #define STEP_IDLE_TICKS UNSIGNED(4096)      C: 4096u      assembler: 4096
#pragma once

// The assembler's preprocessor defines __ASSEMBLER__.
#if defined(__ASSEMBLER__)
#define UNSIGNED(number) number
#else
#define UNSIGNED(number) number##u
#endif
