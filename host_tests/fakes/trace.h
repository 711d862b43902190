// SPDX-License-Identifier: MIT
// All that a suite of traces sees, folded into one number in which the place of each word counts:
// a compact way to say that two implementations, or two processors, do the same.
#pragma once

#include <stdint.h>

void trace_begin(void);
void trace(uint16_t word);
void trace_long(uint32_t word);

// Of all words since trace_begin.
uint32_t trace_number(void);
