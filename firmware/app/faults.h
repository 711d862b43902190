// SPDX-License-Identifier: MIT
// Faults: the first one since the last clear with its place, and the mask of all that happened. A
// fault takes the permit away and stops every axis. Main loop only.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "base/names.h" // enum fault

struct fault_record {
    uint8_t code; // enum fault, the first since the last clear
    uint8_t axis;
    uint16_t argument;
    uint32_t mask; // bit n: fault n happened
    uint32_t pixel;
};

void faults_start(void);

// Latch a fault, take the permit away and stop every axis.
void faults_latch(enum fault code, uint8_t axis, uint16_t argument);

// The step interrupt of this axis came too late: latch it; time is to be restarted.
void faults_latch_underrun(uint8_t axis);

// This axis made steps that nobody asked for: latch it; time is to be restarted.
void faults_latch_stray(uint8_t axis);

const struct fault_record *faults_record(void);

static inline bool faults_any(void)
{
    return faults_record()->code != FAULT_none;
}

// The timers are out of step with the ledgers: axes_account() and time_check_start() must follow
// before a fault is cleared.
bool faults_time_lost(void);

// Time was restarted, if it was lost, and every axis has been brought to rest.
void faults_clear(void);
