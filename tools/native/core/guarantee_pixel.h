// SPDX-License-Identifier: MIT
// What a line's pixels cost: which way the decoder takes for each of them, how many entries it
// writes at once, and what these cost to decode and to account for. Conditions are those of the
// firmware's decoder (firmware/core/axis/decode.c, firmware/core/steps).
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "guarantee.h"

#define RING_ENTRIES 244.0   // of 252, less what a step may take
#define PERIOD_TICKS 64768.0 // longest period of the timer; longer intervals are cut
#define CHUNK_TICKS  32768.0 // into these and a rest
#define BATCH        60.0    // most steps of one
#define TRAIN_STEPS  16.0    // more go the common way as a train, where one can make them

enum kind { EVEN, TRAIN, SINGLES, CURVED, PIECE, CURVE, ZERO };

// How the steps of a curve are found. A tick by which the interval of a flat curve moves, or by
// which a steep step is guessed wrong, costs beside the step itself; so does a short batch.
struct steps_found {
    double flat, wide, steep, slow;
    double moved, wide_moved, missed, batches;
};

// A piece of a curve: its ticks and steps, its speed at the start, half its acceleration.
struct curve_shape {
    double ticks, steps, speed, half;
    bool whole;   // a short pixel of steep steps alone
    bool goes_on; // as the one before it ended: the first step is foretold
};

// What is written at once: ticks from line zero, entries of the ring, cycles of its account.
struct part {
    double begin, end;
    double entries, steps, account;
    bool mark, train;
    bool whole; // the account takes it as a whole
    bool other; // it is of the common way, a train, or a pixel of many steps
};

struct job {
    struct part part;
    double begin_cycles, begin_units; // to begin its piece, before any of that is written
    double cycles, units;             // to write it, and of the budget of a call
    double front, last_ticks; // of what is written then: its end, and its last period
    bool last;                // of its piece
    bool waits; // nothing is written: the time goes into the step that follows
};

// A line on its way through the decoder.
struct walk {
    const struct guarantee_axis *line;
    uint32_t entry, repeat; // runs that are used up, pixels of the present one that are
    uint32_t pixel;         // pixels that are taken
    bool over, shifted, turned;
    bool quiet;    // the last period makes no pulse: what follows takes the common way
    double speed;  // at the place, steps a pixel
    double going;  // half the acceleration of a curved pixel right before, else 0
    double waited; // ticks without a step right before that are not written
    int32_t count; // of the pixel before
    bool negative;
    // The piece in work.
    enum kind kind;
    bool begun;
    double from, ticks, steps, done, half, start_speed;
    bool changed, begins, goes_on;
    bool common; // steps of the common way, of which no train can be made
};

void walk_begin(struct walk *walk, const struct guarantee_axis *line);

// Take the next piece if none is in work. False when the line is over.
bool walk_piece(struct walk *walk, const struct guarantee_board *board);

// What is written next of the piece in work, in a batch of at most so many steps.
void walk_job(const struct walk *walk,
              const struct guarantee_costs *costs,
              const struct guarantee_board *board,
              double most,
              struct job *job);

// It is written.
void walk_pass(struct walk *walk, const struct job *job);

// Steps k0 to k1 of a curve.
void guarantee_curve(const struct curve_shape *curve,
                     double k0,
                     double k1,
                     struct steps_found *found);

// True where the curve is steep after k steps.
bool guarantee_curve_steep(const struct curve_shape *curve, double k);
