// SPDX-License-Identifier: MIT
// Numbers of the ring (step_ring.h) and of the engine (step_engine.h). The assembly of the step
// interrupt reads this file too, so it may hold nothing but plain numbers.
#pragma once

#include "base/literal.h" // UNSIGNED

// High bytes of the ring's entries:
//
//     00..FC   a single period       FE   a command
//     FD       periods of a train    FF   empty: the writer has not filled the slot
#define STEP_HIGH_TRAIN   UNSIGNED(0xFD)
#define STEP_HIGH_COMMAND UNSIGNED(0xFE)
#define STEP_HIGH_EMPTY   UNSIGNED(0xFF)

// Length of the period that an axis without entries repeats, ticks (256 us at 16 MHz).
#define STEP_IDLE_TICKS UNSIGNED(4096)

// The values of enum step_engine_state; step_engine.h says what each state means. The lowest bit is
// set while a period that pulses may still come. Every state in which the engine takes nothing from
// the ring is STEP_STATE_HALTED or above.
#define STEP_STATE_IDLE    0
#define STEP_STATE_IN_LINE 1
#define STEP_STATE_HALTED  2
#define STEP_STATE_HALTING 3
#define STEP_STATE_PARKED  4
