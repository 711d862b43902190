// SPDX-License-Identifier: MIT
// Seeded pseudo-random numbers (xorshift, 32 bits): the same on every machine.
#pragma once

#include <stdint.h>

// seed: not 0.
void chance_seed(uint32_t seed);
uint32_t chance(void);

// low..high, both included; high - low below 2^32 - 1.
uint32_t chance_between(uint32_t low, uint32_t high);
