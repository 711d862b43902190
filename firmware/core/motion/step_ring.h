// SPDX-License-Identifier: MIT
// The ring of timer-compare entries between the decoder (main loop, the one writer) and the step
// interrupt (the one reader). No lock: an entry becomes visible by the single byte store of its
// high half, and the slot after the newest entry always reads as empty.
//
//     high     low
//     00..FC   any      one timer period; TOP = high:low (0..0xFCFF), length TOP + 1 ticks
//     FD       count    signed: so many periods of run 0 (> 0) or run 1 (< 0), struct pulse_train
//     FE       command  enum step_command; takes no time, the next entry follows at once
//     FF       any      empty: the writer has not been here yet
//
// A run is evenly spaced steps that the interrupt itself carries on from period to period, so that
// constant speed costs the writer one entry for up to 127 steps.
//
// The two halves are separate arrays on 256-byte boundaries, so that an 8-bit index finds both.
#pragma once

#include <stdint.h>

#include "motion/step_codes.h" // STEP_HIGH_*, STEP_IDLE_TICKS

#define STEP_RING_SLOTS 256u

// Longest single period, ticks. Longer intervals are split by the writer.
#define STEP_PERIOD_MAX_TICKS 0xFD00u
// Entries that may stand in the ring: 256 less the empty sentinel, and three that were read last:
// the ledger may look at them again.
#define STEP_RING_CAPACITY 252u

enum step_command {
    STEP_COMMAND_QUIET = 0,    // from the next period on: no STEP edge
    STEP_COMMAND_PULSE = 1,    // from the next period on: a STEP edge in each
    STEP_COMMAND_BEGIN = 2,    // a line begins: from here an empty ring is a fault
    STEP_COMMAND_END = 3,      // the line is over; one idle period, then whatever comes
    STEP_COMMAND_POSITIVE = 4, // direction output, at once
    STEP_COMMAND_NEGATIVE = 5,
};

// Intervals of base or base + 1 ticks, interleaved so that every step falls on the first whole tick
// at or after its exact place (even.h): with T = base * n + remainder ticks for n steps
//
//     sum >= 0: base + 1 now, sum += remainder - n        sum < 0: base now, sum += remainder
//
// Written by the main loop while no entry of the ring refers to it; then the interrupt's. Offsets
// are known to the assembly handler.
struct pulse_train {
    volatile int16_t sum;
    int16_t after_short; // remainder
    int16_t after_long;  // remainder - n
    uint8_t short_low;   // low byte of base - 1
    uint8_t long_low;    //   of base
    uint8_t top_high;    // high byte of both: a base that ends in FF carries no remainder
};

#define STEP_TRAINS 2u
// Steps of a run in one entry.
#define STEP_TRAIN_ENTRY_MAX 127u

struct step_ring {
    volatile uint8_t low[STEP_RING_SLOTS];
    volatile uint8_t high[STEP_RING_SLOTS];
} __attribute__((aligned(256)));
