// SPDX-License-Identifier: MIT
// Every placement of a few hardware events over the points of every sequence of actions. Behind
// each action comes a round of the main loop, as on the board.
//
// Equal states at the same point of the same piece of program, with equally many events left, are
// one: what follows is the same. Behind each round every state is brought to rest and judged.
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
    double sequences; // of actions
    double schedules; // placements along the longest of them
    uint64_t states;  // at points and between pieces
    uint64_t runs;    // from a state to the next
    uint64_t judged;  // states brought to rest and judged
    uint16_t points;  // most in one piece
};

// False when something does not hold; then the way there has been reported.
bool search_scenario(uint16_t scenario,
                     const struct search_limits *limits,
                     struct search_counts *counts,
                     FILE *report);
