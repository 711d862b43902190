// SPDX-License-Identifier: MIT
// How an 8-bit timer makes a clock of so many hertz: it counts `counts` prescaled ticks, then there
// is a match, and the clock's level changes at every match, or at one of `matches`.
//
//     count     /|/|/|/|/|/|/|/|/|/|/|/|      counts * 2^shift ticks a match
//     clock     ______/~~~~~\_____/~~~~~      matches = 3
//
// The hardware changes the level by itself, whatever the program does meanwhile. Where `matches` is
// more than 1, the program must say after each match what the next one does.
#pragma once

#include <stdint.h>

struct clock_out_plan {
    // Value of the timer's clock select bits, CS22..CS20 of timer 2.
    uint8_t select;
    // Matches in half a period of the clock, 1 or more.
    uint8_t matches;
    // Prescaled ticks from one match to the next, 1..256.
    uint16_t counts;
};

// Slowest and fastest clock, Hz.
#define CLOCK_OUT_HZ_MIN 1u
#define CLOCK_OUT_HZ_MAX 5000u

// The plan for CLOCK_OUT_HZ_MIN..CLOCK_OUT_HZ_MAX, of a timer that gets timer_hz. Its clock is as
// near as counts and prescalers allow: 0.8 % off at most. Divides for some 4000 cycles.
struct clock_out_plan clock_out_plan_of(uint16_t hz, uint32_t timer_hz);
