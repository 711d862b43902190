// SPDX-License-Identifier: MIT
// An edge of the pixel clock as its capture interrupt leaves it: the count of the timer, and where
// the step engine of the clock's axis was. The assembler reads this file, too.
#pragma once

#include "build_features.h" // SEVERAL_AXES

// Bits of the notes of a struct captured_edge. BACK: how many periods the edge lies back from the
// one that the engine loaded last. WAS_PARKED: the axis was, and idle_count is the coarse clock's
// low 16 bits. CUT: of the engine's `left` and `cut`, `cut` is not 0.
#define CAPTURED_EDGE_BACK       0x03
#define CAPTURED_EDGE_WAS_PARKED 0x40
#define CAPTURED_EDGE_CUT        0x80

// Ticks from an edge at the pin to the counter value captured for it: two synchroniser stages and
// the edge detector.
#define CAPTURED_EDGE_DELAY_TICKS 3

#if !defined(__ASSEMBLER__)
#include <stdint.h>

struct captured_edge {
    // Count of the timer at the edge, ticks from the start of its period.
    uint16_t ticks;
    // struct engine_sample, of when the handler began, or a little later. Of `left` and `cut` one
    // is 0.
    uint8_t tail;
    int8_t left_or_cut;
#if SEVERAL_AXES
    uint16_t idle_count;
#else
    // Its low byte: an edge does not wait for as long as 256 idle periods, 65 ms.
    uint8_t idle_count;
#endif
    // CAPTURED_EDGE_BACK and the others.
    uint8_t notes;
};
#endif
