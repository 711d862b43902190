// SPDX-License-Identifier: MIT
// What the step interrupt's assembly and C halves share. Included by both.
#pragma once

#include "config.h" // CONFIG_AXES

// Layout of struct step_engine and of the rings, checked in step_timer.c.
#define STEP_ISR_ENGINE_SIZE 6
#define STEP_ISR_TAIL        0
#define STEP_ISR_STATE       1
#define STEP_ISR_IDLE_COUNT  2
#define STEP_ISR_RING_SIZE   512
#define STEP_ISR_HIGH_OFFSET 256

#if !defined(__ASSEMBLER__)
#include "motion/step_engine.h" // struct step_engine

extern struct step_engine step_engines[CONFIG_AXES];
extern struct step_ring step_rings[CONFIG_AXES];
#endif
