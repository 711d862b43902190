// SPDX-License-Identifier: MIT
#include "wire/baud.h"

#define SLOWEST_100 96u
#define FASTEST_100 10000u
// At most 2.5 % off: clock / (divisor * rate) from 39/40 to 41/40.
#define PRODUCT_MIN (BAUD_CLOCK_100 / 41u * 40u + BAUD_CLOCK_100 % 41u * 40u / 41u + 1u)
#define PRODUCT_MAX (BAUD_CLOCK_100 / 39u * 40u + BAUD_CLOCK_100 % 39u * 40u / 39u)
// The standard's 1750 us count above 19200 baud; up to there 3.5 characters, here with the next one.
#define SLOW_100      192u
#define SILENCE_16US  109u   // 1750 us
#define CHARACTER_100 6875u  // 11 bits: 11 s / (100 * 16 us)
#define SLOW_WAIT_100 30937u // 49.5 bits

uint8_t baud_divisor(uint16_t baud_100)
{
    return (uint8_t)((BAUD_CLOCK_100 + baud_100 / 2u) / baud_100);
}

bool baud_possible(uint16_t baud_100)
{
    uint16_t product = 0;

    if (baud_100 >= SLOWEST_100 && baud_100 <= FASTEST_100) {
        product = (uint16_t)(baud_divisor(baud_100) * baud_100);
    }
    return product >= PRODUCT_MIN && product <= PRODUCT_MAX;
}

uint16_t baud_silence_16us(uint16_t baud_100)
{
    return baud_100 <= SLOW_100 ? SLOW_WAIT_100 / baud_100
                                : (uint16_t)(SILENCE_16US + CHARACTER_100 / baud_100);
}
