// SPDX-License-Identifier: MIT
//
// The pixel-clock source: an exact rational frequency, off by so many ppm, with jitter and
// drop-outs. Pulses keep to an ideal time line without drift; each one's rising edge is rounded
// down to a cycle and then displaced by its own jitter. High for a quarter of the period, 50 us
// at most.
#pragma once

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "noise.h"

__extension__ typedef unsigned __int128 pixel_wide;

struct pixel_clock_settings {
    uint32_t hz_num, hz_den; // 0: no clock at all
    double ppm;              // kept to a millionth of a ppm
    uint32_t jitter_ns;      // each edge is off by at most this, evenly spread
    double start_ms;         // of the first rising edge
    uint64_t seed;
};

struct pixel_pulse {
    uint64_t rise, fall; // cycles
};

struct pixel_clock {
    struct pixel_clock_settings settings;
    FILE *log;           // one rising edge a line; NULL for none
    uint64_t ideal;      // next pulse: whole cycles
    pixel_wide rest;     // and the fraction, in units of 1 / den
    pixel_wide num, den; // the period is num / den cycles
    struct noise random;
    uint64_t last_fall;
    uint64_t drop; // so many pulses are still to be left out
    bool on, next_valid;
    struct pixel_pulse next;
};

// Starts the source. log_path NULL: no log. False with errno set if the log cannot be written.
bool pixel_clock_open(struct pixel_clock *clock,
                      const struct pixel_clock_settings *settings,
                      const char *log_path);

// The next pulse if it rises before this cycle; it is then over and done with (and in the log).
bool pixel_clock_next(struct pixel_clock *clock,
                      uint64_t before,
                      struct pixel_pulse *pulse);

// Another frequency error from the next pulse on.
void pixel_clock_set_ppm(struct pixel_clock *clock, double ppm);

// Another frequency: the next pulse rises one period behind this cycle.
void pixel_clock_set_hz(struct pixel_clock *clock,
                        uint32_t hz_num,
                        uint32_t hz_den,
                        uint64_t cycle);

void pixel_clock_close(struct pixel_clock *clock);
