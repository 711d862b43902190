// SPDX-License-Identifier: MIT
// The judge's own model of the axes: which lines the host has queued, where each of their edges
// belongs, and what has happened that may end them. It asks nothing of the firmware but where a
// line's first edge is.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "config.h" // CONFIG_AXES

#define JUDGE_ANY_NUMBER 255u
#define JUDGE_LINES      4u // that an axis may have queued

// Lines that the host sends, as two/board.c has them.
enum line_kind {
    LINE_NONE,
    LINE_OF_22, // a train, a few single periods, an interval of several periods, a reversal
    LINE_OF_24, // another rhythm, reversals inside, one together with the other line's
    LINE_OF_50, // a train as long as some pixels
    LINE_OF_2,
};

struct judged_line {
    uint8_t kind; // enum line_kind
    bool clocked; // it waits for the clock
};

struct judged_axis {
    int32_t position; // edges made, signed
    uint32_t zero_ticks;
    struct judged_line lines[JUDGE_LINES]; // the first one is being made
    uint8_t made;                          // edges of that one
    uint8_t edges_allowed;
    uint8_t arm_number; // which accepted `arm` it was
    bool zero_known;
    bool waits;       // for `go` with its token
    bool must_finish; // armed, and nothing has happened that may end it
};

// Part of the state that the search saves.
struct judged {
    struct judged_axis axes[CONFIG_AXES];
    uint8_t arms; // accepted
    bool permit_given;
    bool may_fault; // something has happened that may bring a fault
};

extern struct judged judged;

// What the host was told: orders that were accepted, for the axes of this mask; a line of an axis.
void judge_queued(uint8_t axis, enum line_kind line, bool clocked);
void judge_armed(uint8_t mask, bool by_token);
void judge_went(void);          // `go` with the right token
void judge_ended(uint8_t mask); // stopped, disarmed or discarded
