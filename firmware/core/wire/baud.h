// SPDX-License-Identifier: MIT
// The serial port's clock for a rate, in units of 100 baud from 96 on. All of it fits 16 bits.
//
//     setting baud_100 --> baud_possible()? --> baud_divisor() --> port's divisor (hal/uart.h)
//                                                    |
//                                                    +--> baud_silence_counts() --> port's silence
//
// Every function may be called from any context; none of them keeps state.
#pragma once

#include <stdbool.h>
#include <stdint.h>

// The port's clock is the CPU clock divided by 8. This constant is the number of its counts in a
// second, in units of 100: 20000 at 16 MHz. The build passes the value of the board.
#if !defined(BAUD_CLOCK_100)
#define BAUD_CLOCK_100 20000u
#endif

// Counts of the port's clock for one bit. At 9600 baud, the slowest rate, a clock faster than about
// 19.5 MHz needs more than 8 bits.
#if BAUD_CLOCK_100 / 96u < 255u
typedef uint8_t baud_counts;
#else
typedef uint16_t baud_counts;
#endif

// Counts of the port's clock for one bit, rounded to the nearest: 2 at baud_100 = 10000 and 208 at
// baud_100 = 96 with 16 MHz. The function subtracts instead of dividing, because nothing else in
// the firmware needs a division of 16 bits; it takes 7 cycles for each count of the result.
// baud_100: 96..10000; with 0 the function would never return.
baud_counts baud_divisor(uint16_t baud_100);

// True when baud_100 is from 96 to 10000 (9600 to 1,000,000 baud) and the rate that the rounded
// divisor gives is within 2.5 % of it. A setting that is not possible is refused.
bool baud_possible(uint16_t baud_100);

// The silence that ends a frame, for uart_set(): the time from the end of one byte to the end of
// the next one when 3.5 characters of silence lie between them (1750 us above 19200 baud). The
// result is in counts of 256 CPU cycles (16 us at 16 MHz), rounded down: 321 at divisor 208, 110 at
// divisor 2. A character has 11 bits.
//
//     bus    |byte|<--- 3.5 characters --->|byte|
//                 |<-- silence_counts ---------->|
uint16_t baud_silence_counts(baud_counts divisor);
