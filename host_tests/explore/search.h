// SPDX-License-Identifier: MIT
// Every placement of a few hardware events over the points of every sequence of actions.
//
// The program runs on a stack of its own. At each of its points it can be left, and gone on with
// later from what was saved: its memory, its stack and the place in it. That is a state; equal ones
// at the same point of the same piece of program, with equally many events left, are one. A piece
// is an action or a round of the main loop.
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
    uint64_t states;  // at points and between pieces
    uint64_t runs;    // from a state to the next
    uint64_t judged;  // states brought to rest and judged
    uint16_t points;  // most in one piece
};

// False when something does not hold; then it has been reported.
bool search_scenario(uint8_t scenario,
                     const struct search_limits *limits,
                     struct search_counts *counts,
                     FILE *report);

// For the part and the judge, while a piece runs.

void search_point(void);       // the program is at a point
void search_clear_stack(void); // what a handler left below is no part of a state
bool search_undisturbed(void); // no event was placed in this piece
