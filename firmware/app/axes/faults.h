// SPDX-License-Identifier: MIT
// The first fault since the last clear, with its place, and the mask of all faults since then. A
// fault switches the permit off, halts every axis and drops the start token. Whoever notices
// something wrong latches it here by its name; the registers and the event log show it. Main loop
// only: the emergency stop's interrupt halts the axes by itself (hal/estop.h), and its fault is
// latched in the next round.
//
//     fault 1, fault 3, fault 1 ...    record: code, axis, argument and pixel of the first one
//                                      mask:   bit 1 and bit 3
//     faults_clear()                   record: FAULT_none, mask: 0
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "base/names.h" // enum fault
#include "config.h"     // CONFIG_INDEX

// faults.c alone writes it.
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

// Switch the permit off, halt every axis and latch the fault. axis: 0..CONFIG_AXES-1; argument: as
// faults.def says for this fault. May be called again at any time: the record keeps the first
// fault, the mask takes every one. The axis's pixel is taken from its account as it is.
void faults_latch_at(enum fault code, uint8_t axis, uint16_t argument);

// faults_latch_at(); with a single axis the compiler sees that the axis is 0.
static inline void faults_latch(enum fault code, uint8_t axis, uint16_t argument)
{
    faults_latch_at(code, CONFIG_INDEX(axis), argument);
}

// faults_latch_at() with the argument 0.
void faults_latch_plain_at(enum fault code, uint8_t axis);

// faults_latch() with the argument 0.

static inline void faults_latch_plain(enum fault code, uint8_t axis)
{
    faults_latch_plain_at(code, CONFIG_INDEX(axis));
}

// The step interrupt of this axis came too late: latch the fault and request a restart of time. An
// emergency stop that has come by then is latched first.
void faults_latch_underrun(uint8_t axis);

// This axis made steps that nobody requested: latch the fault and request a restart of time.
void faults_latch_stray(uint8_t axis);

// What is latched; the object lasts as long as the program.
const struct fault_record *faults_record(void);

// True when a fault is latched.
static inline bool faults_any(void)
{
    return faults_record()->code != FAULT_none;
}

// True when the timers and the ledgers disagree: axes_advance_rested() and time_check_start() must
// run before the fault is cleared.
bool faults_time_lost(void);

// Forget the faults. Only once every axis is at rest, and time was restarted where it was lost.
void faults_clear(void);
