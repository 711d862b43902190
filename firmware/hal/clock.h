// SPDX-License-Identifier: MIT
// Coarse time for silences and time-outs; never for motion.
#pragma once

#include <stdint.h>

void clock_start(void);

// Units of 4 us since clock_start(); wraps after 4.7 hours.
uint32_t clock_now_4us(void);

// Units of 1.024 ms, which wrap after 67 s: for times of up to a minute that may last 2 % longer.
static inline uint16_t clock_now_ms(void)
{
    return (uint16_t)(clock_now_4us() >> 8);
}
