// SPDX-License-Identifier: MIT
//
// The CPU clock of a run. Time is counted in its cycles everywhere, also by what is outside of the
// boards (pixel clock, serial bus, plants): all boards of one run have the same clock.
#pragma once

#include <stdint.h>

// Once, before anything else of the run is made; a whole number of MHz.
void cpu_clock_set(uint32_t hz);

uint32_t cpu_clock_hz(void);

// Cycles of a time, from 1 us and 1 ms up.
uint64_t cpu_clock_cycles_of_us(uint64_t us);
uint64_t cpu_clock_cycles_of_ms(uint64_t ms);
