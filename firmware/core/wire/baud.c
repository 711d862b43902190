// SPDX-License-Identifier: MIT
#include "wire/baud.h"

#include "base/apart.h" // APART

#define SLOWEST_100 96u
#define FASTEST_100 10000u
// A rate may be off by 2.5 % at most: clock / (divisor * rate) is between 39/40 and 41/40.
#define PRODUCT_MIN (BAUD_CLOCK_100 / 41u * 40u + BAUD_CLOCK_100 % 41u * 40u / 41u + 1u)
#define PRODUCT_MAX (BAUD_CLOCK_100 / 39u * 40u + BAUD_CLOCK_100 % 39u * 40u / 39u)
// The silence that ends a frame is 3.5 characters up to 19200 baud and 1750 us above, by the
// standard. The next character is added, because the receiver reports a character at its end.
#define SLOW_DIVISOR   ((BAUD_CLOCK_100 + 96u) / 192u)
#define SILENCE_COUNTS ((uint16_t)(BAUD_CLOCK_100 * 7uL / 1280u)) // 1750 us

// Divide by subtraction, which takes less room than the library's division.
APART baud_counts baud_divisor(uint16_t baud_100)
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

// A bit takes 8 cycles times the divisor, and a count is 256 cycles. Times the divisor, a character
// of 11 bits is therefore 88/256 of a count, and 4.5 characters (49.5 bits) are 1 + 140/256.
uint16_t baud_silence_counts(baud_counts divisor)
{
    uint16_t first = divisor >= SLOW_DIVISOR ? divisor : SILENCE_COUNTS;
    uint8_t part = divisor >= SLOW_DIVISOR ? 140u : 88u;

    return (uint16_t)(first + ((uint16_t)(part * divisor) >> 8));
}
