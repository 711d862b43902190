// SPDX-License-Identifier: MIT
//
// What is wrong with the pixel clock at one board's pin while the clock itself, and the pins of the
// other boards, are clean: edges that are missing, false edges, jitter of the pin's own.
//
//   clock        /-\_______/-\_______/-\_______/-\______
//   this pin     /-\_______/-\__/-\____________/-\______      double 1, then miss 3
//                 0         1          (2)      3
//
// A false edge is a short pulse between those of the clock. One that falls into a pulse of the
// clock comes right after it; one without room before the next pulse is lost.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "noise.h"
#include "pixel_clock.h"

#define PIN_FLAWS_MAX 32 // that wait, of each sort

enum pin_flaw_kind {
    PIN_FLAW_MISS, // this edge is missing
    PIN_FLAW_ADD,  // a false edge follows this one
};

// A flaw that waits for its edge.
struct pin_flaw {
    enum pin_flaw_kind kind;
    uint64_t edge;  // true edges before it, from the start on
    uint32_t phase; // of the false edge: thousandths of the period after the true one
};

struct pin_flaws {
    struct pin_flaw flaw[PIN_FLAWS_MAX];
    unsigned flaws;
    uint64_t pulse[PIN_FLAWS_MAX]; // false edges to come: their cycles, in order
    unsigned pulses;
    uint64_t edges;         // true edges of the clock so far
    uint32_t jitter_cycles; // each edge is displaced by at most this, evenly distributed
    struct noise random;
    uint64_t last_fall; // of the last pulse on the pin
};

// A clean pin. Boards have different random numbers from one seed.
void pin_flaws_init(struct pin_flaws *pin, uint64_t seed, unsigned board);

// Adds a flaw at the nth edge to come (1: the next). False if PIN_FLAWS_MAX wait.
bool pin_flaws_add(struct pin_flaws *pin,
                   enum pin_flaw_kind kind,
                   uint64_t nth,
                   uint32_t phase);

// Adds a false edge at a cycle to come. False if PIN_FLAWS_MAX wait.
bool pin_flaws_pulse(struct pin_flaws *pin, uint64_t cycle);

// A pulse of the clock comes: its own jitter displaces it. Call for each pulse, in order; then take
// the false edges before it, and pass it.
void pin_flaws_displace(struct pin_flaws *pin, struct pixel_pulse *pulse);

// Takes the next false edge before this cycle. Its pulse ends before `limit`, where the clock's
// next one may begin. False if there is none.
bool pin_flaws_false(struct pin_flaws *pin,
                     uint64_t before,
                     uint64_t limit,
                     struct pixel_pulse *pulse);

// Passes a pulse of the clock, which has this period, and adds the false edge that follows it.
// False if the pulse is missing on this pin.
bool pin_flaws_pass(struct pin_flaws *pin,
                    const struct pixel_pulse *pulse,
                    uint64_t period);
