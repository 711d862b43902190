// SPDX-License-Identifier: MIT

#include "cpu_clock.h"

static uint32_t clock_hz = 16000000U;

void cpu_clock_set(uint32_t hz)
{
    clock_hz = hz;
}

uint32_t cpu_clock_hz(void)
{
    return clock_hz;
}

uint64_t cpu_clock_cycles_of_us(uint64_t us)
{
    return us * (clock_hz / 1000000U);
}

uint64_t cpu_clock_cycles_of_ms(uint64_t ms)
{
    return ms * (clock_hz / 1000U);
}
