// SPDX-License-Identifier: MIT
// Where the interval changes by less than four ticks from step to step, everything about the next
// step follows from this one by additions. For curve.c.
//
// Two intervals serve for a while, q and q + 1; which of them a step takes is the sign of a sum. At
// a place where the next step is due, all exact modulo 2^40 (modulo 2^32 where that is enough):
//
//     residual     position beyond the last step in 1/T^2 steps
//     gain         residual after q ticks, minus the residual now   = q*(slope + h*(q-1)) - T*T
//     difference   what the last of these ticks adds                = slope + 2h*(q-1)
//     slope_growth         growth of slope and difference over q ticks      = 2h*q
//     gain_growth         growth of gain over q ticks                      = 2h*q*q
//
// slope is what the next tick adds, (speed * T, and h). The step takes q ticks if residual + gain
// is not negative, else q + 1: then difference and gain have grown by 2h and slope_growth more than behind
// a step of q ticks. When neither will do, q itself moves by one: the table says what changes.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "base/wide.h"          // struct wide
#include "motion/curve_place.h" // struct curve_place, struct curve_made

struct step_ring;

struct curve_flat {
    struct wide residual;
    struct wide gain;
    struct wide difference;
    struct wide gain_growth;
    int32_t slope_growth;
    int16_t twice_half; // 2h
    uint16_t top;       // q - 1, as the ring wants it
};

enum curve_flat_kind {
    CURVE_FLAT_NOT,
    CURVE_FLAT_NARROW, // modulo 2^32
    CURVE_FLAT_WIDE,   // modulo 2^40
};

// How a piece of T ticks between two speeds (not above 32767) begins; stays: it is flat to its end.
enum curve_flat_kind curve_flat_kind(uint32_t ticks,
                                     uint16_t start_speed,
                                     uint16_t end_speed,
                                     bool *stays);

// What is flat now, below four ticks from step to step, up to this speed.
enum curve_flat_kind curve_flat_now(uint32_t ticks, uint16_t top_speed);

// From a place whose next interval is about so long, within the change from step to step.
void curve_flat_enter(struct curve_flat *flat,
                      const struct curve_place *at,
                      uint16_t interval_ticks);

// The place behind the last step, but for T*T.
void curve_flat_leave(const struct curve_flat *flat, struct curve_place *at);

// `count` steps (not 0) into the ring's slots from `slot` on, but for the high byte of the first.
void curve_flat_burst(struct curve_flat *flat,
                      bool narrow,
                      struct step_ring *ring,
                      uint8_t slot,
                      uint8_t count,
                      struct curve_made *made);

// One step: its ticks.
uint16_t curve_flat_next(struct curve_flat *flat, bool narrow);
