// SPDX-License-Identifier: MIT
// The ring of timer-compare entries. The decoder in the main loop is the only writer, the step
// interrupt the only reader, so that no lock is needed: an entry becomes visible by the single
// store of its high byte, and the slot after the newest entry always reads as empty.
//
//     high     low
//     00..FC   any      one timer period; TOP = high:low (0..0xFCFF), length TOP + 1 ticks
//     FD       count    signed: that many periods of train 0 (> 0) or 1 (< 0), struct pulse_train
//     FE       command  enum step_command; takes no time, the next entry follows at once
//     FF       any      empty: the writer has not filled this slot yet
//
// A pulse train is a sequence of evenly spaced steps that the interrupt continues by itself from
// period to period. At constant speed the writer therefore needs only one entry for up to 127
// steps.
//
// High and low bytes are two arrays on 256-byte boundaries, so that one 8-bit index finds both
// bytes.
#pragma once

#include <stdint.h>

#include "ring/step_codes.h" // STEP_HIGH_*, STEP_IDLE_TICKS

// An 8-bit index wraps at this number of slots.
// Slots from `retired` (ledger) up to `head` (feed) are in use; `tail` (engine) lies between.
#define STEP_RING_SLOTS 256u

// Longest single period, ticks. The writer splits longer intervals.
#define STEP_PERIOD_MAX_TICKS 0xFD00u
// Entries that may be in the ring: 256 less the empty slot after the newest entry, less the three
// entries that were read last, because the ledger may look at these again.
#define STEP_RING_CAPACITY 252u

enum step_command {
    // From the next period on: no STEP edge.
    STEP_COMMAND_QUIET = 0,
    // From the next period on: each period begins with a STEP edge.
    STEP_COMMAND_PULSE = 1,
    // A line begins: from here on an empty ring is a fault.
    STEP_COMMAND_BEGIN = 2,
    // The line is over: one idle period, then whatever follows.
    STEP_COMMAND_END = 3,
    // Set the direction output to positive at once, inside the running period. The writer puts this
    // command where the running period does not pulse.
    STEP_COMMAND_POSITIVE = 4,
    // As STEP_COMMAND_POSITIVE, but to negative.
    STEP_COMMAND_NEGATIVE = 5,
};

// Intervals of base or base + 1 ticks, interleaved so that every step falls on the first whole tick
// at or after its exact place (even.h). With T = base * n + remainder ticks for n steps:
//
//     sum >= 0: base + 1 now, sum += remainder - n        sum < 0: base now, sum += remainder
//
// The main loop writes a train while no entry of the ring refers to it; afterwards the train
// belongs to the interrupt, which writes `sum` alone. The assembly handler knows the members'
// offsets.
struct pulse_train {
    // The fraction carried from step to step, in units of 1/n tick; its sign chooses the interval.
    volatile int16_t sum;
    // Added to the sum after a short interval: the remainder, 0..n-1.
    int16_t after_short;
    // Added to the sum after a long interval: the remainder minus n, -n..-1.
    int16_t after_long;
    // Low byte of the short interval's TOP, base - 1.
    uint8_t short_low;
    // Low byte of the long interval's TOP, base.
    uint8_t long_low;
    // High byte of both: a train with a remainder has no base that ends in FF.
    uint8_t top_high;
};

// Trains of an axis: one is being made while the other is being written.
#define STEP_TRAINS 2u
// Most steps of a train in one entry.
#define STEP_TRAIN_ENTRY_MAX 127u

// The main loop writes both arrays, the step interrupt only reads them. An entry's high byte lies
// 256 bytes after its low byte: one step of an address's upper byte leads from one to the other.
struct step_ring {
    // Low bytes of the entries; the low byte of an empty slot means nothing.
    volatile uint8_t low[STEP_RING_SLOTS];
    // High bytes of the entries: STEP_HIGH_TRAIN and the others, or less for a single period.
    volatile uint8_t high[STEP_RING_SLOTS];
} __attribute__((aligned(256)));
