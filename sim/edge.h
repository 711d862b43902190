// SPDX-License-Identifier: MIT
//
// One edge of an output signal of a board, or of the pixel clock: the currency between the boards,
// which make edges, and the logs, which write them.
#pragma once

#include <stdint.h>

enum edge_signal {
    EDGE_STEP,
    EDGE_DIR,
    EDGE_ENABLE,
    EDGE_PERMIT,    // of the whole board: axis 0
    EDGE_CLOCK_OUT, // the same
    EDGE_CLOCK,     // of the whole bench: board 0, axis 0
    EDGE_SIGNALS,
};

struct edge {
    uint64_t cycle; // first, as struct row_queue needs it
    uint8_t board;  // its number on the bench
    uint8_t axis;   // of the board, 0 if the signal belongs to all axes
    uint8_t signal; // an enum edge_signal
    uint8_t level;  // after the edge, 0 or 1
};

// The signal's name in the files of edges, e.g. "STEP".
const char *edge_signal_name(unsigned signal);
