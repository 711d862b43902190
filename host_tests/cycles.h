// SPDX-License-Identifier: MIT
// Cycles that code takes on a simulated board. Natively no cycles are counted.
//
// Timer 1 runs freely at the CPU clock, in mode 15 with the highest TOP, which the simulator counts
// exactly.
#pragma once

#include <stdint.h>

#if defined(__AVR__)
#include <avr/io.h>

static inline void cycles_start(void)
{
    OCR1A = 0xFFFFu;
    TCCR1A = (uint8_t)((1u << WGM11) | (1u << WGM10));
    TCCR1B = (uint8_t)((1u << WGM13) | (1u << WGM12) | (1u << CS10));
}

// Cycles since some instant, modulo 65536.
static inline uint16_t cycles_now(void)
{
    return TCNT1;
}

#else

static inline void cycles_start(void)
{
}

static inline uint16_t cycles_now(void)
{
    return 0;
}

#endif
