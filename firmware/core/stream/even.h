// SPDX-License-Identifier: MIT
// Evenly spaced steps: step j of n in a piece of T ticks falls at ceil(j * T / n), the last one
// exactly at T. A step takes no multiplication and no division. The decoder walks along pieces and
// pulse trains this way; the account repeats the walk to find where a step of a train lies. Main
// loop only.
//
//     T = 10, n = 4     base 2, remainder 2
//     intervals         3     2     3     2
//     steps at        0  ..  3  ..  5  ..  8  ..  10        ceil(2.5), 5, ceil(7.5), 10
//
// The fraction is an integer that is carried, so that no error adds up however long the piece is.
#pragma once

#include <stdint.h>

// A walk along a piece. A copy of it is a second walk along the same piece.
struct even {
    // Shorter interval: floor(T / n), ticks.
    uint32_t base_ticks;
    // T mod n, 0..n-1: how many of the n intervals are one tick longer.
    uint16_t remainder;
    // n, the number of steps of the piece, 1..32767. Steps that were passed do not change it.
    uint16_t steps;
    // The fraction carried from step to step, in units of 1/n tick, 0..n-1. It is n - 1 at the
    // start, which makes a ceiling of the floor.
    uint16_t sum;
};

// Begin a piece. ticks: T, 1..2^24; steps: n, 1..32767. Divides. Boards of several axes look first
// whether the quotient in *even is the right one already, as it is from pixel to pixel of a
// constant speed: one product shows that, and saves the division. *even may hold anything before.
void even_start(struct even *even, uint32_t ticks, uint16_t steps);

// Pass over `steps` steps at once, 0..n, never beyond the end of the piece. Returns the ticks from
// the last step before the call to the last of these. Divides, except for n steps at once.
uint32_t even_skip(struct even *even, uint16_t steps);

// Pass over one step. Returns the ticks from the last step, or from the start of the piece, to this
// step. At most n times for one piece, the steps of even_skip() included.
static inline uint32_t even_next(struct even *even)
{
    uint16_t sum = (uint16_t)(even->sum + even->remainder);
    uint32_t ticks = even->base_ticks;

    if (sum >= even->steps) {
        sum = (uint16_t)(sum - even->steps);
        ticks++;
    }
    even->sum = sum;
    return ticks;
}
