// SPDX-License-Identifier: MIT
// Steps under constant acceleration inside one piece of T ticks: start speed v0 (steps a piece), n
// steps, half-acceleration h = n - v0. Step k falls at the smallest whole tick t with
//
//     v0*T*t + h*t*t >= k*T*T
//
// The distance of a step's tick from its exact place is a small number, the residual. The residual
// is kept exactly, so that each interval follows from the last one without roots or divisions: by
// additions where the interval hardly changes (curve_flat.h), by a guess and its correction
// elsewhere (curve_steep.h). walk.c begins a curve for each curved piece; decode.c takes the steps.
// Main loop only.
//
//     ticks          |    |    |    |    |    |    |    |
//     exact places      k        k + 1      k + 2
//     steps               ^         ^         ^          the first tick at or after each place
//                         |residual: how far the curve is beyond k at the tick of step k
//
//     curve_start() --+--> steep -- speeds up, changes less --> flat to its end
//                     +--> flat --- slows down, changes more --> steep
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "steps/curve_flat.h"  // struct curve_flat, struct curve_made
#include "steps/curve_steep.h" // struct curve_steep

// One piece on its way. A curve may become flat as it speeds up, and steep as it slows down.
struct curve {
    union {
        struct {
            // The numbers of the steps that follow.
            struct curve_flat flat;
            // T, ticks, for the way back to the steep decoder.
            uint32_t ticks;
        } flat;
        // The steep decoder's place and its last intervals.
        struct curve_steep steep;
    } state;
    // enum curve_flat_kind. CURVE_FLAT_NOT: state.steep is valid, else state.flat.
    uint8_t kind;
    // The curve is flat to its end; of a flat curve only.
    bool stays;
};

// Begin a piece. ticks: T, 1024..2^24-1. start_speed: v0, steps a piece, and the end speed 2n - v0:
// 0..32767. steps: n, 1 or more. Divides, and may take a root.
void curve_start(struct curve *curve,
                 uint32_t ticks,
                 uint16_t start_speed,
                 uint16_t steps);

// Make one step. Returns the ticks from the last step, or from the start of the piece, to this one.
// For steps 1..n-1; the caller places step n at the end of the piece. May change the decoder, and
// costs much more than a step of a batch.
uint32_t curve_next(struct curve *curve);

// Make up to `count` steps (not 0) into the ring's slots from `slot` on, as long as the fast
// decoders can make them. made->steps is 0 when curve_next() must make the next step. Each slot
// gets both bytes of interval - 1, except that the high byte of the first slot is only returned:
// the caller's store of that byte publishes all steps. The slots must be free, and the slot after
// them must read as empty by then.
void curve_burst(struct curve *curve,
                 struct step_ring *ring,
                 uint8_t slot,
                 uint8_t count,
                 struct curve_made *made);

// The number of steps, `count` at most, that may be made next as steps of a narrow curve by
// curve_flat_burst(); 0 if the curve is not narrow. count: not 0. May make the curve steep.
uint8_t curve_narrow(struct curve *curve, uint8_t count);
