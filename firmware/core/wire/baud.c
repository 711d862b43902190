// SPDX-License-Identifier: MIT
#include "wire/baud.h"

#define SLOWEST_100 96u
#define FASTEST_100 10000u
// At most 2.5 % off: clock / (divisor * rate) from 39/40 to 41/40.
#define PRODUCT_MIN (BAUD_CLOCK_100 / 41u * 40u + BAUD_CLOCK_100 % 41u * 40u / 41u + 1u)
#define PRODUCT_MAX (BAUD_CLOCK_100 / 39u * 40u + BAUD_CLOCK_100 % 39u * 40u / 39u)
// The standard's 1750 us count above 19200 baud, 3.5 characters up to there; plus the next one.
#define SLOW_DIVISOR   ((BAUD_CLOCK_100 + 96u) / 192u)
#define SILENCE_COUNTS ((uint16_t)(BAUD_CLOCK_100 * 7uL / 1280u)) // 1750 us

// Without a division, which nothing else of the firmware's 16 bits needs.
baud_counts baud_divisor(uint16_t baud_100)
{
    uint16_t left = (uint16_t)(BAUD_CLOCK_100 + baud_100 / 2u);
    baud_counts divisor = 0;

    for (; left >= baud_100; divisor++) {
        left = (uint16_t)(left - baud_100);
    }
    return divisor;
}

bool baud_possible(uint16_t baud_100)
{
    uint16_t product = 0;

    if (baud_100 >= SLOWEST_100 && baud_100 <= FASTEST_100) {
        product = (uint16_t)(baud_divisor(baud_100) * baud_100);
    }
    return product >= PRODUCT_MIN && product <= PRODUCT_MAX;
}

// A bit is 8 cycles by the divisor: 11 bits are 88/256 of a count, 49.5 bits 1 + 140/256.
uint16_t baud_silence_counts(baud_counts divisor)
{
    uint16_t first = divisor >= SLOW_DIVISOR ? divisor : SILENCE_COUNTS;
    uint8_t part = divisor >= SLOW_DIVISOR ? 140u : 88u;

    return (uint16_t)(first + ((uint16_t)(part * divisor) >> 8));
}
