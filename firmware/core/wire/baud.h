// SPDX-License-Identifier: MIT
// The serial line's clock for a rate, in units of 100 baud from 96 on. All of it fits 16 bits.
#pragma once

#include <stdbool.h>
#include <stdint.h>

// What the line's clock counts in a second, in units of 100: 16 MHz by 8.
#define BAUD_CLOCK_100 20000u

// Counts of that clock a bit, rounded to the nearest: 2 at 10000, 208 at 96. Takes 7 cycles each.
uint8_t baud_divisor(uint16_t baud_100);

// The rate that the divisor gives is within 2.5 %. False below 9600 baud and above 1,000,000.
bool baud_possible(uint16_t baud_100);

// From the end of a byte to the end of the next one when 3.5 characters of silence lie between
// them (1750 us above 19200 baud), in units of 16 us, rounded down: 321 at divisor 208, 110 at 2. A
// character has 11 bits.
uint16_t baud_silence_16us(uint8_t divisor);
