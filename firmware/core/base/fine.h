// SPDX-License-Identifier: MIT
// Ticks with a fraction: numbers of 48 bits in memory, for times that are averaged over many edges
// of the pixel clock. The clock's filter and the grid of locked pixels use them. Sums wrap at 2^32
// ticks. The AVR has the functions in assembly (fine.S, which includes this file too); every other
// compiler gets the C below, which is also what the assembly means.
//
//     byte      0     1     2     3     4     5
//     member   |fraction   |ticks, lowest first    |
//     weight    2^-16 2^-8  1     2^8   2^16  2^24    ticks
//
// The functions have no state of their own and may be called from any context, as long as nobody
// else uses the same numbers meanwhile: a number is not written by one instruction.
#pragma once

// Where an event lies inside its tick, in units of 1/65536 tick. A counter tells only the beginning
// of the tick, and on average the event is half a tick later. The constant is a little less than a
// half, so that events at the very beginnings of ticks are still rounded to those ticks.
#define FINE_TICK_CENTRE 0x7000

#if !defined(__ASSEMBLER__)
#include <stddef.h> // offsetof
#include <stdint.h>

// A time or a length: (ticks * 65536 + fraction) / 65536 ticks. A negative length is stored as its
// two's complement of 48 bits.
struct fine_ticks {
    // The part below a tick, in units of 1/65536 tick.
    uint16_t fraction;
    // Whole ticks, rounded down; wraps.
    uint32_t ticks;
};

#if defined(__AVR__)
_Static_assert(offsetof(struct fine_ticks, ticks) == 2u &&
                   sizeof(struct fine_ticks) == 6u,
               "one number of six bytes, the lowest first: known to fine.S");

// *to += *by, modulo 2^32 ticks. The two may be the same number, which doubles it. 79 cycles with
// the call (82 on the ATmega2560).
void fine_add(struct fine_ticks *to, const struct fine_ticks *by);

// Correct a place and a step by an error of the place. pair[0] is the place, pair[1] the step.
// error_ticks: the captured tick minus the whole ticks of the place. The exact error is error_ticks
// plus FINE_TICK_CENTRE minus the fraction of the place. shift: 0..7.
//
//     place = place + error / 2^shift
//     step  = step  + error / 2^(2 * shift + 1)      shift 0: step = step + error
//
// Both corrections are rounded to the nearest unit. Rounded down, the step would be too short by
// half a unit, and a prediction would carry that half once for each step ahead. 120 cycles with the
// call, and 18 for each shift (123 on the ATmega2560).
void fine_track(struct fine_ticks *pair, int32_t error_ticks, uint8_t shift);
#else
// The same functions in C.

// *to += *by. A carry out of the fraction shows as a sum below one of its terms.
static inline void fine_add(struct fine_ticks *to, const struct fine_ticks *by)
{
    uint16_t fraction = (uint16_t)(to->fraction + by->fraction);

    to->ticks += by->ticks + (fraction < by->fraction ? 1u : 0u);
    to->fraction = fraction;
}

// Halve *length `times` times, rounded down. Returns the last bit that was shifted out, as a length
// of 0 or 1 unit: added to *length, it rounds to the nearest instead. For fine_track() only.
static inline struct fine_ticks fine_halve(struct fine_ticks *length, uint8_t times)
{
    struct fine_ticks rest = {.fraction = 0};

    for (; times != 0; times--) {
        uint16_t carry = (length->ticks & 1u) != 0 ? 0x8000u : 0;
        rest.fraction = length->fraction & 1u;
        length->fraction = (uint16_t)(length->fraction >> 1 | carry);
        length->ticks = length->ticks >> 1 | (length->ticks & 0x80000000uL);
    }
    return rest;
}

// The error is halved to the place's correction first, and from there on to the step's.
static inline void fine_track(struct fine_ticks *pair, int32_t error_ticks, uint8_t shift)
{
    struct fine_ticks error = {
        .fraction = (uint16_t)(FINE_TICK_CENTRE - pair[0].fraction),
        .ticks = (uint32_t)error_ticks - (pair[0].fraction > FINE_TICK_CENTRE ? 1u : 0u),
    };
    struct fine_ticks rest = fine_halve(&error, shift);

    fine_add(&pair[0], &error);
    fine_add(&pair[0], &rest);
    rest = fine_halve(&error, shift == 0 ? 0 : (uint8_t)(shift + 1u));
    fine_add(&pair[1], &error);
    fine_add(&pair[1], &rest);
}
#endif
#endif
