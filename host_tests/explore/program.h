// SPDX-License-Identifier: MIT
// The program under search: the firmware, on a stack of its own. It can be left at every point, and
// gone on with from there as often as wanted. What is saved is its memory and the used part of its
// stack; the memory holds the part's state and the judge's too.
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum program_verdict {
    PROGRAM_FINE,     // a call came back
    PROGRAM_AT_POINT, // left at a point
    PROGRAM_OVER,     // the piece is over
    PROGRAM_BROKEN,   // a rule is broken
    PROGRAM_SHARES,   // an interrupt shares what was not known to be shared: search again
};

#define PROGRAM_ROUND                                                                    \
    254u // the piece that is a round of the main loop; below it, actions

// How to go on.
struct program_task {
    uint8_t piece;
    uint8_t events;  // bit n: enum part_event n happens first
    bool to_the_end; // points are passed
    bool disturbed;  // an event was placed in this piece
};

// Power on. Once; then restore what was saved behind it.
void program_open(void);

// From what was restored last: from a point on, or a new piece.
enum program_verdict program_go(const struct program_task *task);

// Between two pieces, on the caller's stack: what it does is not left at points.
enum program_verdict program_call(void (*function)(void));

const char *program_broken(void);   // the rule
uint16_t program_most_points(void); // in one piece, since asked last
const struct program_task *program_task(void);

size_t program_size(void); // of what is to be saved now
void program_save(uint8_t *memory);
void program_restore(const uint8_t *memory, size_t size);
void program_hash(uint64_t hash[2]);

// In the program.
void program_point(void);
void program_clear_stack(void); // what a handler left below is no part of a state

// Or the end of the whole program.
void *allocate(void *old, size_t bytes);
