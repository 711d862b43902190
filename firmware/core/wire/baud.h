// SPDX-License-Identifier: MIT
// The serial port's clock for a rate, in units of 100 baud from 96 on. All of it fits 16 bits.
#pragma once

#include <stdbool.h>
#include <stdint.h>

// What the port's clock counts in a second, in units of 100: the CPU clock by 8. The build gives
// the board's.
#if !defined(BAUD_CLOCK_100)
#define BAUD_CLOCK_100 20000u
#endif

// Counts of that clock a bit.
#if BAUD_CLOCK_100 / 96u < 255u
typedef uint8_t baud_counts;
#else
typedef uint16_t baud_counts;
#endif

// Rounded to the nearest: 2 at 10000, 208 at 96 with 16 MHz. Takes 7 cycles each.
baud_counts baud_divisor(uint16_t baud_100);

// The rate that the divisor gives is within 2.5 %. False below 9600 baud and above 1,000,000.
bool baud_possible(uint16_t baud_100);

// From the end of a byte to the end of the next one when 3.5 characters of silence lie between
// them (1750 us above 19200 baud), in counts of 256 CPU cycles (16 us at 16 MHz), rounded down: 321
// at divisor 208, 110 at 2. A character has 11 bits.
uint16_t baud_silence_counts(baud_counts divisor);
