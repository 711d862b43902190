// SPDX-License-Identifier: MIT
// Every placement of a few hardware events over the points of every sequence of actions.
//
// A state is the program's whole memory while the main loop is between two pieces of its program,
// so it holds no stack. A piece is an action or a round of the main loop; it is run from a saved
// state again for each placement of events over its points. Equal states with equally many events
// left are one.
#pragma once

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

struct search_limits {
    uint8_t actions; // in a sequence
    uint8_t periods; // ends of periods to place
    uint8_t pins;    // changes of the emergency stop's pin to place
};

struct search_counts {
    double sequences;
    double schedules; // paths: placements along sequences
    uint64_t runs;    // pieces of program run
    uint64_t states;
    uint64_t judged; // states brought to rest and judged
    uint16_t points; // most in one piece
};

// False when something does not hold; then it has been reported.
bool search_scenario(uint8_t scenario,
                     const struct search_limits *limits,
                     struct search_counts *counts,
                     FILE *report);
