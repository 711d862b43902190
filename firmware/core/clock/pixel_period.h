// SPDX-License-Identifier: MIT
// The exact pixel period, and the grid of ticks that it makes. P = timer_hz * den / num ticks is
// generally no integer. Pixel edges fall at floor(k * P) for ever and do not drift, because the
// remainder is carried as an integer. The settings make the period (settings_period()); lines and
// the watch of the pixel clock walk along its multiples. Main loop only: setting a period or a
// shifted grid divides.
//
// With numbers far smaller than real ones:
//
//     P = 4 + 2/3 ticks    k       0    1    2     3     4     5
//                          place   0    4    9    14    18    23      floor(k * P)
//                          sum     0    2    1     0     2     1      thirds carried
#pragma once

#include <stdbool.h>
#include <stdint.h>

// Shortest period, ticks.
#define PIXEL_PERIOD_MIN_TICKS 1024u
// Longest period, ticks. 24 bits: down to 1 Hz at 16 MHz, 1.2 Hz at 20 MHz.
// The arithmetic of curves needs pieces below 2^24 ticks.
#define PIXEL_PERIOD_MAX_TICKS 0xFFFFFFu

// P as a mixed number, ticks: P = whole_ticks + remainder / divisor.
struct pixel_period {
    // floor(P), PIXEL_PERIOD_MIN_TICKS..PIXEL_PERIOD_MAX_TICKS.
    uint32_t whole_ticks;
    // 0..divisor-1.
    uint32_t remainder;
    // The numerator of the pixel frequency, 1 or more.
    uint32_t divisor;
};

// Set the period of the frequency num / den Hz: P = timer_hz * den / num ticks, exactly. Returns
// false and changes nothing when num is 0 or floor(P) is outside the limits above; a den of 0 makes
// P 0. Divides.
bool pixel_period_set(struct pixel_period *period,
                      uint32_t timer_hz,
                      uint32_t num,
                      uint32_t den);

// A walk along multiples of P. The period must not change meanwhile. A copy is a second walk.
struct pixel_grid {
    // P.
    const struct pixel_period *period;
    // Fraction of the present place, in units of 1/divisor tick, 0..divisor-1.
    uint32_t sum;
};

// Place the grid at 0. The period must last as long as the grid.
void pixel_grid_start(struct pixel_grid *grid, const struct pixel_period *period);

// Move the grid by P. Returns the whole ticks between the two places: floor(P) or one more. Does
// not divide.
uint32_t pixel_grid_advance(struct pixel_grid *grid);

// Place the grid at P * (line_speed - backlash_steps) / line_speed and return the whole ticks up to
// there, rounded down; the fraction below a tick stays in the grid. line_speed: steps/pixel,
// 1..32767; backlash_steps: 0..line_speed. Divides four times.
uint32_t pixel_grid_start_shifted(struct pixel_grid *grid,
                                  const struct pixel_period *period,
                                  uint16_t backlash_steps,
                                  uint16_t line_speed);

// ticks * share / whole, rounded down, ticks. whole: 1..32767; share: 0..whole. Divides.
uint32_t pixel_share_ticks(uint32_t ticks, uint16_t share, uint16_t whole);
