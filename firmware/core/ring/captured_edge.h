// SPDX-License-Identifier: MIT
// An edge of the pixel clock as its capture interrupt leaves it: the count of the timer, and where
// the step engine of the clock's axis was. The handler has no time to place the edge; the main loop
// places it later, by the account of the axis whose timer captured it (ledger.h). The assembler
// reads this file too.
//
//     timer's periods   | back 1: running | back 0: loaded |
//     edge at the pin          ^  ticks = its count in that period
//     handler begins              ^ tail, left_or_cut, idle_count: what the engine has taken by now
#pragma once

#include "build_features.h" // SEVERAL_AXES

// Bits of the notes of a struct captured_edge. BACK: how many periods the edge lies back from the
// period that the engine loaded last. WAS_PARKED: the axis was parked, and idle_count has the low
// 16 bits of the coarse clock. CUT: left_or_cut has the engine's `cut`, else its `left`.
#define CAPTURED_EDGE_BACK       0x03
#define CAPTURED_EDGE_WAS_PARKED 0x40
#define CAPTURED_EDGE_CUT        0x80

// Ticks from an edge at the pin to the counter value captured for it: two synchroniser stages and
// the edge detector.
#define CAPTURED_EDGE_DELAY_TICKS 3

#if !defined(__ASSEMBLER__)
#include <stdint.h>

// Written by the capture interrupt, read by the main loop. The members from `tail` to idle_count
// are those of struct step_engine as the handler saw them, or a little later.
struct captured_edge {
    // Count of the timer at the edge, ticks from the start of the edge's period.
    uint16_t ticks;
    // Slot of the ring that the engine reads next.
    uint8_t tail;
    // The engine's `left`, or its `cut` if CAPTURED_EDGE_CUT is set: one of the two is always 0.
    int8_t left_or_cut;
#if SEVERAL_AXES
    // Idle periods loaded so far, or the coarse clock with CAPTURED_EDGE_WAS_PARKED; wraps.
    uint16_t idle_count;
#else
    // Low byte of the number of idle periods: an edge does not wait for as long as 256 idle
    // periods, 65 ms.
    uint8_t idle_count;
#endif
    // CAPTURED_EDGE_BACK and the others.
    uint8_t notes;
};
#endif
