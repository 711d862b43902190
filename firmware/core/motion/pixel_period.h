// SPDX-License-Identifier: MIT
// The exact pixel period and the tick grid it makes. P = timer_hz * den / num ticks is generally
// not an integer; boundaries fall at floor(k * P) for ever, with no drift, because the remainder
// is carried as an integer.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#define PIXEL_PERIOD_MIN_TICKS 1024u
#define PIXEL_PERIOD_MAX_TICKS                                                           \
    0xFFFFFFu // 24 bits: down to 1 Hz at 16 MHz, 1.2 Hz at 20 MHz

struct pixel_period {
    uint32_t whole_ticks; // floor(P)
    uint32_t remainder;   // P = whole + remainder / divisor
    uint32_t divisor;
};

// pixel_hz = num / den. False (and unchanged) when a term is 0 or P is outside the limits above.
bool pixel_period_set(struct pixel_period *period,
                      uint32_t timer_hz,
                      uint32_t num,
                      uint32_t den);

// A walk along multiples of P. The period must stay as it is meanwhile.
struct pixel_grid {
    const struct pixel_period *period;
    uint32_t sum; // fraction of the present place, 0..divisor-1
};

// Grid at 0.
void pixel_grid_start(struct pixel_grid *grid, const struct pixel_period *period);

// Ticks (floor to floor) from the present place to the one P further.
uint32_t pixel_grid_advance(struct pixel_grid *grid);

// Grid at P * (line_speed - backlash) / line_speed. The ticks up to there. line_speed 1..32767,
// backlash not above it.
uint32_t pixel_grid_start_shifted(struct pixel_grid *grid,
                                  const struct pixel_period *period,
                                  uint16_t backlash_steps,
                                  uint16_t line_speed);
