// SPDX-License-Identifier: MIT
// Adds up the single periods of a ring. The account passes periods this way where no waypoint tells
// the time (ledger.h), so that the AVR has the function in assembly, 16 cycles a period; the C that
// the assembly stands for is beside it. Main loop only.
//
//     slots    | p | p | p | command | p | ...      p: a single period, high byte below FD
//     *slot      ^ before    ^ after
//
// The ledger calls the function for entries that the step interrupt has taken, and for single
// periods around them that still stand in the ring. Between the two slots nothing may be written
// meanwhile.
#pragma once

#include "ring/step_ring.h" // struct step_ring

// Add the lengths of the single periods from *slot on, up to the slot `stop` or to the first entry
// that is not a single period, whichever comes first. Slots wrap at 256; *slot equal to `stop` adds
// nothing. Moves *slot to the slot where the sum ends. Returns the sum, ticks, below 2^24.
#if defined(__AVR__)
static inline uint32_t step_ring_sum(const struct step_ring *ring,
                                     uint8_t *slot,
                                     uint8_t stop)
{
    uint8_t first = *slot;
    const volatile uint8_t *high = &ring->high[first];
    uint32_t sum = 0;

    // Z walks through the page of the high bytes; the page below it holds the low bytes.
    __asm__ volatile("rjmp 2f\n"
                     "1: ld __tmp_reg__, Z\n\t"
                     "ldi r26, %[train]\n\t"
                     "cp __tmp_reg__, r26\n\t"
                     "brsh 3f\n\t"
                     "dec %B[high]\n\t"
                     "ld r26, Z\n\t"
                     "inc %B[high]\n\t"
                     "inc %A[high]\n\t"
                     "add %A[sum], r26\n\t"
                     "adc %B[sum], __tmp_reg__\n\t"
                     "adc %C[sum], __zero_reg__\n"
                     "2: cpse %A[high], %[stop]\n\t"
                     "rjmp 1b\n"
                     "3:\n\t"
                     : [high] "+z"(high), [sum] "+r"(sum)
                     : [stop] "r"(stop), [train] "M"(STEP_HIGH_TRAIN)
                     : "r26", "memory");
    // The ring is aligned to 256 bytes, so that the low byte of the address is the slot. The loop
    // added high:low of each entry, and a period is one tick longer.
    *slot = (uint8_t)(uintptr_t)high;
    return sum + (uint8_t)(*slot - first);
}
#else
// The same function in C, for every other processor.
static inline uint32_t step_ring_sum(const struct step_ring *ring,
                                     uint8_t *slot,
                                     uint8_t stop)
{
    uint32_t sum = 0;

    while (*slot != stop && ring->high[*slot] < STEP_HIGH_TRAIN) {
        sum += ((uint32_t)ring->high[*slot] << 8 | ring->low[*slot]) + 1u;
        (*slot)++;
    }
    return sum;
}
#endif
