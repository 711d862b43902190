// SPDX-License-Identifier: MIT
// For curve.c: the steps of a curve whose interval changes by less than four ticks from step to
// step. Everything about the next step follows from this one by additions.
//
// Two intervals serve for a while, q and q + 1; the sign of a sum decides which of them a step
// takes. Before each step these numbers are kept, all exact modulo 2^40 (modulo 2^32 where that is
// enough):
//
//     residual      position beyond the last step in 1/T^2 steps
//     gain          residual after q ticks, minus the residual now   = q*(slope + h*(q-1)) - T*T
//     difference    what the last of these ticks adds                = slope + 2h*(q-1)
//     slope_growth  growth of slope and difference over q ticks      = 2h*q
//     gain_growth   growth of gain over q ticks                      = 2h*q*q
//
// slope is what the next tick adds (speed * T, and h). The step takes q ticks if residual + gain is
// not negative, else q + 1: then difference and gain have grown by 2h and slope_growth more than
// after a step of q ticks. When neither interval fits, q itself moves by one, and the table shows
// which numbers change. Main loop only.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "base/wide.h"         // struct wide
#include "steps/curve_place.h" // struct curve_place, struct curve_made

struct step_ring;

// The numbers of the table, in units of 1/T^2 steps. The assembly works on them. The functions
// below write them; curve.c reads them to choose the decoder.
struct curve_flat {
    // Position beyond the last step.
    struct wide residual;
    // Growth of the residual over q ticks, less one step.
    struct wide gain;
    // What the last of these ticks adds.
    struct wide difference;
    // Growth of `gain` over a step.
    struct wide gain_growth;
    // Growth of `difference` over a step; negative where the curve slows down.
    int32_t slope_growth;
    // 2h: what slope grows by from tick to tick; negative where the curve slows down.
    int16_t twice_half;
    // q - 1, ticks, as the ring wants it.
    uint16_t top;
};

enum curve_flat_kind {
    // The interval changes too much: curve_steep.h.
    CURVE_FLAT_NOT,
    // Computed modulo 2^32. Only in images with FEATURE_NARROW_CURVES.
    CURVE_FLAT_NARROW,
    // Computed modulo 2^40.
    CURVE_FLAT_WIDE,
};

// The kind with which a piece begins. ticks: T, 1024..2^24-1; speeds: steps a piece, 0..32767, not
// equal. *stays: the piece is flat to its end. A piece that speeds up and is not flat from its
// start may become flat later, and one that slows down may become steep.
enum curve_flat_kind curve_flat_kind(uint32_t ticks,
                                     uint16_t start_speed,
                                     uint16_t end_speed,
                                     bool *stays);

// The kind of a curve that is flat now and whose speed does not exceed top_speed, steps a piece.
// loose: its interval may change by up to four ticks from step to step, else by up to one. The
// result is CURVE_FLAT_NOT where even 40 bits are too few.
enum curve_flat_kind curve_flat_now(uint32_t ticks, uint16_t top_speed, bool loose);

// Begin at a place whose next interval is about interval_ticks (1..65535), within the change from
// step to step.
void curve_flat_enter(struct curve_flat *flat,
                      const struct curve_place *at,
                      uint16_t interval_ticks);

// The place after the last step, for the steep decoder to go on from. Members step and step_low of
// *at stay as they are.
void curve_flat_leave(const struct curve_flat *flat, struct curve_place *at);

// Make `count` steps (not 0) into the ring's slots from `slot` on, except for the high byte of the
// first slot, which made->first_high returns: the caller's store of that byte publishes all steps.
// narrow: the kind is CURVE_FLAT_NARROW.
void curve_flat_burst(struct curve_flat *flat,
                      bool narrow,
                      struct step_ring *ring,
                      uint8_t slot,
                      uint8_t count,
                      struct curve_made *made);

// Make one step. Returns its interval, ticks. narrow: as for curve_flat_burst().
uint16_t curve_flat_next(struct curve_flat *flat, bool narrow);
