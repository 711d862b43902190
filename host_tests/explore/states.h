// SPDX-License-Identifier: MIT
// States of the program, found again by their hash, and how each was first reached.
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "explore/part.h" // PART_EVENT_KINDS

struct state {
    uint64_t hash[2];
    double schedules; // that lead here
    uint8_t *memory;
    size_t size;
    uint32_t step;                  // the last one of the way here
    uint8_t left[PART_EVENT_KINDS]; // events still to be placed
};

struct layer {
    struct state *states;
    uint32_t count, room;
    uint32_t *slots; // of the hash table, number + 1
    uint32_t slot_count;
};

// The state of this hash; a new one, without memory, if it is not there.
struct state *layer_find(struct layer *layer, const uint64_t hash[2]);
void layer_empty(struct layer *layer);
// The next layer is in work; the one that was is emptied for what comes after it.
void layer_swap(struct layer *now, struct layer *next);

#define STEP_FIRST    UINT32_MAX // the parent of the first step
#define STEP_NO_PIECE 255u

struct step {
    uint32_t parent;
    uint16_t point;
    uint8_t piece;  // that came to its end, STEP_NO_PIECE: only events happened
    uint8_t events; // bit n: enum part_event n, at that point
    const void *pc; // of the program there
};

struct steps {
    struct step *steps;
    uint32_t count, room;
};

uint32_t steps_add(struct steps *steps, const struct step *step);
