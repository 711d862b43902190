// SPDX-License-Identifier: MIT
// The first fault since the last clear, with its place, and the mask of all faults since then. A
// fault switches the permit off and halts every axis. Main loop only.
//
//     fault 1, fault 3, fault 1 ...    record: code, axis, argument and pixel of the first one
//                                      mask:   bit 1 and bit 3
//     faults_clear()                   record: FAULT_none, mask: 0
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "base/names.h" // enum fault
#include "config.h"     // CONFIG_INDEX

struct fault_record {
    // enum fault, the first since the last clear.
    uint8_t code;
    // Axis of that fault.
    uint8_t axis;
    // Argument of that fault (faults.def).
    uint16_t argument;
    // Bit n: fault n happened since the last clear.
    uint32_t mask;
    // Pixel of the axis's line in which the first fault happened, 1-based.
    uint32_t pixel;
};

// No fault.
void faults_start(void);

// Switch the permit off, halt every axis and latch the fault.
void faults_latch_at(enum fault code, uint8_t axis, uint16_t argument);

// The same. Where there is one axis, no call says which.
static inline void faults_latch(enum fault code, uint8_t axis, uint16_t argument)
{
    faults_latch_at(code, CONFIG_INDEX(axis), argument);
}

// The same with the argument 0.
void faults_latch_plain_at(enum fault code, uint8_t axis);

static inline void faults_latch_plain(enum fault code, uint8_t axis)
{
    faults_latch_plain_at(code, CONFIG_INDEX(axis));
}

// The step interrupt of this axis came too late: latch the fault and request a restart of time. An
// emergency stop that has come by then is latched first.
void faults_latch_underrun(uint8_t axis);

// This axis made steps that nobody requested: latch the fault and request a restart of time.
void faults_latch_stray(uint8_t axis);

// What is latched.
const struct fault_record *faults_record(void);

// A fault is latched.
static inline bool faults_any(void)
{
    return faults_record()->code != FAULT_none;
}

// The timers and the ledgers disagree: axes_advance_rested() and time_check_start() must run before
// the fault is cleared.
bool faults_time_lost(void);

// Forget the faults, once every axis is at rest and time was restarted where it was lost.
void faults_clear(void);
