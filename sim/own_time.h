// SPDX-License-Identifier: MIT
//
// A board's own time beside the bench's. The bench counts in cycles of the first board's
// oscillator; another board's may be off by some ppm, or have another nominal frequency. Within a
// board all times are cycles of its own; what comes from outside and what goes out is converted:
//
//   bench   0     1000     2000     3000        pixel clock, bus, other boards, logs, commands
//   board   0     1250     2500     3750        of 20 MHz beside one of 16 MHz
#pragma once

#include <math.h>
#include <stdbool.h>
#include <stdint.h>

__extension__ typedef unsigned __int128 own_wide;

#define OWN_TIME_PPM_SCALE 1000000000.0 // ppm are kept to a thousandth
#define OWN_TIME_PPM_UNITS 1000.0

struct own_time {
    uint64_t num, den; // num cycles of the board are den of the bench
};

// The time of a board whose oscillator is off by so much.
static inline struct own_time own_time_of(uint32_t board_hz,
                                          uint32_t bench_hz,
                                          double ppm)
{
    double scale = OWN_TIME_PPM_SCALE + round(ppm * OWN_TIME_PPM_UNITS);

    if (board_hz == bench_hz && !(fabs(ppm) > 0)) {
        return (struct own_time){.num = 1, .den = 1};
    }
    return (struct own_time){.num = board_hz * (uint64_t)scale,
                             .den = bench_hz * (uint64_t)OWN_TIME_PPM_SCALE};
}

// The first cycle of the board that is not before this one of the bench.
static inline uint64_t own_time_from_bench(const struct own_time *time, uint64_t bench)
{
    own_wide scaled = (own_wide)bench * time->num;

    return (time->num == time->den) ? bench
                                    : (uint64_t)((scaled + time->den - 1) / time->den);
}

// The cycle of the bench within which this one of the board begins.
static inline uint64_t own_time_to_bench(const struct own_time *time, uint64_t own)
{
    return (time->num == time->den) ? own
                                    : (uint64_t)((own_wide)own * time->den / time->num);
}
