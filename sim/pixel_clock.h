// SPDX-License-Identifier: MIT
//
// The source of the pixel clock: an exact rational frequency with an error in ppm that may wander
// and step, jitter, missing and false edges. The pulses follow an ideal time line without drift;
// the rising edge of each is rounded down to a cycle and then displaced by its own jitter. A pulse
// is high for a quarter of the period, 50 us at most.
//
//   ideal     |           |           |           |        num / den cycles apart, exactly
//   clock     /-\___________/-\______/-\___/-\_______/-    displaced by jitter
//               true         true     true  false   missing
//
// A gate lets so many edges pass, then the time line stands still for the rest:
//
//   ideal     |     |     |                       |     |     |         gate of 3 edges
//   clock     /-\___/-\___/-\_____________________/-\___/-\___/-\___
//                            period |<-- rest -->|
//
// The log has a row for each true edge, missing ones included, and for each false one: the cycle in
// which it rises, the ideal time in thousandths of a cycle (of a false edge that of the true edge
// before it), and which of these it is. While the clock is off nothing is logged.
#pragma once

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "noise.h"

__extension__ typedef unsigned __int128 pixel_wide;

struct pixel_clock_settings {
    uint32_t hz_num, hz_den; // 0: no clock at all
    double ppm;              // kept to a millionth of a ppm
    uint32_t jitter_ns;      // each edge is displaced by at most this, evenly distributed
    uint32_t jitter_rms_ns;  // and by this standard deviation, normally distributed
    double wander_ppm;       // amplitude of a sine in the frequency
    double step_ppm;         // added to the frequency error
    uint64_t step_edge;      // from this edge on, the first one being 0; 0: never
    uint32_t drop_every;     // one edge of so many is missing; 0: none
    uint32_t double_every;   // one of so many, unless missing, is followed by a false one
    uint32_t gate_edges;     // after so many edges the clock rests; 0: never
    double gate_rest_ms;     // so long, besides the period, before the next so many edges
    double start_ms;         // of the first rising edge
    uint64_t seed;           // of jitter and false edges
};

// Edges of one period of the wander.
#define PIXEL_CLOCK_WANDER_EDGES 1000

enum pixel_edge {
    PIXEL_EDGE_TRUE,
    PIXEL_EDGE_MISSING,
    PIXEL_EDGE_FALSE,
};

struct pixel_pulse {
    uint64_t rise;       // cycle of the edge that the firmware counts
    uint64_t fall;       // cycle of the other edge
    uint64_t true_x1000; // the ideal time
    enum pixel_edge kind;
};

struct pixel_clock {
    struct pixel_clock_settings settings;
    FILE *log;           // of every edge; NULL for none
    uint64_t edge;       // number of the true edge that `ideal` is
    uint64_t ideal;      // of the next pulse without jitter: whole cycles
    pixel_wide rest;     // and the fraction, in units of 1 / den
    pixel_wide num, den; // the period is num / den cycles
    struct noise random;
    uint64_t last_fall;  // of the last pulse made,
    uint64_t given_fall; // and of the last one taken
    uint64_t drop;       // number of pulses that are still to be dropped
    uint32_t burst;      // edges since the gate's last rest
    bool on;             // off: pulses are left out, but the time line goes on
    bool next_valid;     // `next` holds the next pulse
    bool false_due;      // the pulse behind it is a false one
    struct pixel_pulse next;
};

// Its name in the logs.
const char *pixel_edge_name(enum pixel_edge kind);

// Starts the source, and its log unless log_path is NULL. False with errno set if the log cannot be
// written.
bool pixel_clock_open(struct pixel_clock *clock,
                      const struct pixel_clock_settings *settings,
                      const char *log_path);

// Takes the next pulse if it rises before this cycle, and logs it. False if there is none. Missing
// pulses, and those while the clock is off, are left out.
bool pixel_clock_next(struct pixel_clock *clock,
                      uint64_t before,
                      struct pixel_pulse *pulse);

// Changes the frequency error, from the next pulse on.
void pixel_clock_set_ppm(struct pixel_clock *clock, double ppm);

// Changes how far each edge is displaced, from the next pulse on: at most so much, evenly
// distributed, and by this standard deviation.
void pixel_clock_set_jitter(struct pixel_clock *clock,
                            uint32_t jitter_ns,
                            uint32_t jitter_rms_ns);

// Changes the gate: the next pulse is the first one of so many (0: no gate).
void pixel_clock_set_gate(struct pixel_clock *clock, uint32_t edges, double rest_ms);

// The time line stands still for so many cycles: all further pulses rise so much later.
void pixel_clock_rest(struct pixel_clock *clock, uint64_t cycles);

// The period without jitter, in cycles.
uint64_t pixel_clock_period(const struct pixel_clock *clock);

// The cycle before which no further pulse rises, as long as no command changes the clock.
uint64_t pixel_clock_quiet(const struct pixel_clock *clock);

// Where a false edge lies, at random: thousandths of the period after the true edge before it.
uint32_t pixel_clock_false_phase(struct noise *random);

// Changes the frequency; the next pulse rises one period after this cycle, and the gate's edges are
// counted from there.
void pixel_clock_set_hz(struct pixel_clock *clock,
                        uint32_t hz_num,
                        uint32_t hz_den,
                        uint64_t cycle);

// Closes the log; false if it could not be written whole.
bool pixel_clock_close(struct pixel_clock *clock);
