// SPDX-License-Identifier: MIT
// The ring of timer-compare entries between the decoder (main loop, the one writer) and the step
// interrupt (the one reader). No lock: an entry becomes visible by the single byte store of its
// high half, and the slot after the newest entry always reads as empty.
//
//     high     low
//     00..FD   any      one timer period; TOP = high:low (0..0xFDFF), length TOP + 1 ticks
//     FE       command  enum step_command; takes no time, the next entry follows at once
//     FF       any      empty: the writer has not been here yet
//
// The two halves are separate arrays so that the interrupt finds them with an 8-bit index; on the
// AVR each ring is placed on a 256-byte boundary.
#pragma once

#include <stdint.h>

#define STEP_RING_SLOTS   256u
#define STEP_HIGH_COMMAND 0xFEu
#define STEP_HIGH_EMPTY   0xFFu

// Longest single period, ticks. Longer intervals are split by the writer.
#define STEP_PERIOD_MAX_TICKS 0xFE00u
// Entries that may stand in the ring: 256 less the empty sentinel and one to tell full from empty.
#define STEP_RING_CAPACITY 254u
// Length of the period that an axis without entries repeats, ticks (256 us at 16 MHz).
#define STEP_IDLE_TICKS 4096u

enum step_command {
    STEP_COMMAND_QUIET = 0,    // from the next period on: no STEP edge
    STEP_COMMAND_PULSE = 1,    // from the next period on: a STEP edge in each
    STEP_COMMAND_BEGIN = 2,    // a line begins: from here an empty ring is a fault
    STEP_COMMAND_END = 3,      // the line is over; one idle period, then whatever comes
    STEP_COMMAND_POSITIVE = 4, // direction output, at once
    STEP_COMMAND_NEGATIVE = 5,
};

struct step_ring {
    volatile uint8_t low[STEP_RING_SLOTS];
    volatile uint8_t high[STEP_RING_SLOTS];
};
