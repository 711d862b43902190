// SPDX-License-Identifier: MIT
// Ticks with a fraction: numbers of 48 bits in memory, for times that are averaged. Sums wrap at
// 2^32 ticks. In assembly on the AVR, the C that it stands for otherwise. May be called from any
// context.
// Included by fine.S, too.
#pragma once

// A counter tells the beginning of the tick that an event lies in. On average the event is half a
// tick later, in units of 1/65536 tick; a little less, so that events at the very beginnings of
// ticks are still rounded to those.
#define FINE_TICK_CENTRE 0x7000

#if !defined(__ASSEMBLER__)
#include <stddef.h> // offsetof
#include <stdint.h>

// A time or a length: (ticks * 65536 + fraction) / 65536 ticks. A negative length is its two's
// complement.
struct fine_ticks {
    uint16_t fraction;
    uint32_t ticks;
};

#if defined(__AVR__)
_Static_assert(offsetof(struct fine_ticks, ticks) == 2u &&
                   sizeof(struct fine_ticks) == 6u,
               "one number of six bytes, the lowest first: known to fine.S");

// *to += *by. 79 cycles with the call (82 on the ATmega2560).
void fine_add(struct fine_ticks *to, const struct fine_ticks *by);

// Correct the pair of a place and a step by an error of the place, which is error_ticks plus
// FINE_TICK_CENTRE less the fraction of the place: the place by error / 2^shift, then the step by
// error / 2^(2 * shift + 1), or by all of it when the shift is 0. Rounded: rounded down, the step
// would be too short by half a unit for each of the steps ahead. 120 cycles with the call, and 18
// for each shift (123 on the ATmega2560).
void fine_track(struct fine_ticks *pair, int32_t error_ticks, uint8_t shift);
#else
static inline void fine_add(struct fine_ticks *to, const struct fine_ticks *by)
{
    uint16_t fraction = (uint16_t)(to->fraction + by->fraction);

    to->ticks += by->ticks + (fraction < by->fraction ? 1u : 0u);
    to->fraction = fraction;
}

// Halve *length this many times, rounded down. Add the result to round to the nearest instead.
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
