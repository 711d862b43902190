// SPDX-License-Identifier: MIT
// The coarse clock for code that runs with interrupts off or in an interrupt, where hal/clock.h
// could be wrong: timer 0's interrupt may be running underneath.
#pragma once

#include <avr/io.h>
#include <stdbool.h>
#include <stdint.h>

#include "avr/hal/flag_bits.h" // FLAG_CLOCK_COUNTING

// Timer 0's overflows, changed with interrupts off where there are several axes.
extern volatile uint32_t clock_overflows;

struct clock_look {
    uint16_t overflows;
    uint8_t count;
    bool pending; // an overflow has come that may not be counted
};

// Called with interrupts off: 8 cycles.
static inline struct clock_look clock_look(void)
{
    uint8_t count = TCNT0;
    uint8_t flags = (uint8_t)(TIFR0 & _BV(TOV0));
    uint8_t counting = (uint8_t)(GPIOR0 & _BV(FLAG_CLOCK_COUNTING));

    return (struct clock_look){
        .overflows = *(const volatile uint16_t *)&clock_overflows,
        .count = count,
        .pending = (flags | counting) != 0,
    };
}

// Units, modulo 2^24. A large count was read before the wrap that set the flag.
static inline uint32_t clock_look_units(const struct clock_look *look)
{
    uint16_t overflows = look->overflows;

    if (look->pending && look->count < 128u) {
        overflows++;
    }
    return ((uint32_t)overflows << 8) | look->count;
}
