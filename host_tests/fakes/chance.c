// SPDX-License-Identifier: MIT
#include "fakes/chance.h"

static uint32_t state = 1;

void chance_seed(uint32_t seed)
{
    state = seed;
}

uint32_t chance(void)
{
    state ^= state << 13;
    state ^= state >> 17;
    state ^= state << 5;
    return state;
}

uint32_t chance_between(uint32_t low, uint32_t high)
{
    return low + chance() % (high - low + 1u);
}
