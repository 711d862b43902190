// SPDX-License-Identifier: MIT
// A broken promise ends the run: the fuzzer keeps the input that broke it.
#pragma once

#include <stdbool.h>

// Does nothing when the promise is kept; else says what is wrong, and ends the program.
__attribute__((format(printf, 2, 3))) void promise(bool kept, const char *format, ...);
