// SPDX-License-Identifier: MIT
// A coarse clock for silences and time-outs; never for motion. Main loop only.
//
// The clock counts units of CLOCK_UNIT_TICKS timer ticks: 4 us at 16 MHz, 3.2 us at 20 MHz.
// Settings are in microseconds and milliseconds; the functions below convert them, without a
// division where the conversion happens in every round.
#pragma once

#include <stdint.h>

#include "config.h" // CONFIG_TIMER_HZ

// Timer ticks a unit.
#define CLOCK_UNIT_TICKS 64u

// Units in 256 us, and milliseconds in 256 times 256 units, rounded down: a time is up to 0.5 %
// longer than its setting.
#define CLOCK_UNITS_A_256US  (CONFIG_TIMER_HZ / 250000uL)
#define CLOCK_MS_A_64K_UNITS (256uL * 256uL * CLOCK_UNIT_TICKS * 1000uL / CONFIG_TIMER_HZ)

// Start counting at 0. Interrupts off.
void clock_start(void);

// Units since clock_start(); wraps after some hours (4.7 at 16 MHz).
uint32_t clock_now_units(void);

// Units of a setting in microseconds, rounded down.
static inline uint16_t clock_units_of_us(uint16_t us)
{
    return CLOCK_UNITS_A_256US == 64u ? us / 4u
                                      : (uint16_t)((us * CLOCK_UNITS_A_256US) >> 8);
}

// Milliseconds, which wrap after 65 s: for times of up to a minute that may last 2.4 % longer.
static inline uint16_t clock_now_ms(void)
{
    uint32_t units_256 = clock_now_units() >> 8;

    // At 16 MHz 256 units are 1.024 ms: near enough.
    return (uint16_t)(CLOCK_UNITS_A_256US == 64u
                          ? units_256
                          : (units_256 * CLOCK_MS_A_64K_UNITS) >> 8);
}

// Milliseconds of a time in units, exact; divides.
static inline uint32_t clock_ms_of_units(uint32_t units)
{
    // 8 ms are 125 units for each tick that a microsecond has.
#define CLOCK_UNITS_8MS (125uL * (CONFIG_TIMER_HZ / 1000000uL))
#if CLOCK_UNITS_8MS % 8uL == 0
    return units / (CLOCK_UNITS_8MS / 8uL);
#else
    return units / CLOCK_UNITS_8MS * 8u + units % CLOCK_UNITS_8MS * 8u / CLOCK_UNITS_8MS;
#endif
}
