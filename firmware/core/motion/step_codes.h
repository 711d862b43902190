// SPDX-License-Identifier: MIT
// Numbers of the ring (step_ring.h) and of the engine (step_engine.h), for the step interrupt's
// assembly, too: plain numbers only.
#pragma once

#include "base/literal.h" // UNSIGNED

// High bytes of the ring's entries. Below STEP_HIGH_TRAIN: a single period.
#define STEP_HIGH_TRAIN   UNSIGNED(0xFD)
#define STEP_HIGH_COMMAND UNSIGNED(0xFE)
#define STEP_HIGH_EMPTY   UNSIGNED(0xFF)

// Length of the period that an axis without entries repeats, ticks (256 us at 16 MHz).
#define STEP_IDLE_TICKS UNSIGNED(4096)

// enum step_engine_state. The lowest bit: in a line, or not quite out of it.
#define STEP_STATE_IDLE    0
#define STEP_STATE_IN_LINE 1
#define STEP_STATE_HALTED  2
#define STEP_STATE_HALTING 3
