// SPDX-License-Identifier: MIT
// How many idle periods a parked axis has made. A parked axis is at rest and its interrupts are
// off, which leaves their cycles to the axes that move. Its timer runs on with the idle period, in
// phase, and no interrupt counts; the coarse clock (hal/clock.h) and the timer's own counter tell
// the number. avr/hal/step_parked.c reads both and asks the functions below.
//
//     timer     |0 ... counter       |0 ...               |0 ...     STEP_IDLE_TICKS each
//     clock     '''''''''''''''''''''''''''''''''''''''''''''''''    PARKED_UNIT_TICKS each
//                                    ^ units - counter: start of the period, to a few units
//     count     n                    n + 1                n + 2
//
// Only the distance of two starts is rounded, and that distance is a whole number of periods: the
// result is right while the two clocks are read within PARKED_SLACK_TICKS of each other. No error
// adds up, so that an axis may be parked for any time. Of the units only bits 0 to 21 matter; the
// bits above them may be anything.
//
// The functions have no state and may be called from any context.
#pragma once

#include <stdint.h>

#include "ring/step_codes.h" // STEP_IDLE_TICKS

// Ticks in a unit of the coarse clock, and units in an idle period.
#define PARKED_UNIT_TICKS   64u
#define PARKED_PERIOD_UNITS (STEP_IDLE_TICKS / PARKED_UNIT_TICKS)
// The most that may lie between the looks at the coarse clock and at the counter, ticks.
#define PARKED_SLACK_TICKS 1900u

#if STEP_IDLE_TICKS % 64 != 0
#error "an idle period must be a whole number of units"
#endif

// The base of an axis that is being parked, which goes to the functions below. idle_count: idle
// periods counted so far. counter: where the timer stands, 0..STEP_IDLE_TICKS-1. units: what the
// coarse clock shows, read within PARKED_SLACK_TICKS of the counter.
static inline uint32_t parked_base(uint32_t units, uint16_t counter, uint16_t idle_count)
{
    return units - counter / PARKED_UNIT_TICKS - PARKED_PERIOD_UNITS / 2u -
           (uint32_t)idle_count * PARKED_PERIOD_UNITS;
}

// Idle periods made up to the instant at which counter and coarse clock were read, modulo 2^16. The
// idle_count that was given to parked_base() is a part of the result.
static inline uint16_t parked_count(uint32_t base, uint32_t units, uint16_t counter)
{
    return (uint16_t)((units - counter / PARKED_UNIT_TICKS - base) / PARKED_PERIOD_UNITS);
}

// Idle periods made up to an edge that was captured at count `captured`, modulo 2^16. units: low 16
// bits of the coarse clock, read at most PARKED_SLACK_TICKS after the edge. now_count: the result
// of parked_count() at any time within a quarter of a second after the edge; it supplies the bits
// that 16 bits of units cannot tell.
static inline uint16_t parked_count_at(uint32_t base,
                                       uint16_t units,
                                       uint16_t captured,
                                       uint16_t now_count)
{
    uint16_t since = (uint16_t)(units - captured / PARKED_UNIT_TICKS - (uint16_t)base);
    uint16_t periods = since / (uint16_t)PARKED_PERIOD_UNITS;
    // The number of periods that 16 bits of units hold, less 1.
    uint16_t mask = (uint16_t)(0x10000uL / PARKED_PERIOD_UNITS - 1u);

    return (uint16_t)(now_count - (uint16_t)((uint16_t)(now_count - periods) & mask));
}
