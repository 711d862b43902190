// SPDX-License-Identifier: MIT
// What the step interrupt's assembly and C halves share. Included by both.
#pragma once

#include "base/literal.h"      // UNSIGNED
#include "config.h"            // CONFIG_AXES
#include "motion/step_codes.h" // STEP_HIGH_*, STEP_IDLE_TICKS, STEP_STATE_*

// In OCRnB: above every TOP, so that the timer finds no match and STEP stays low.
#define QUIET_TICKS UNSIGNED(0xFFFF)

// Layout of struct step_engine, of its runs and of the rings, checked in step_timer.c.
#define STEP_ISR_ENGINE_SIZE 28
#define STEP_ISR_TAIL        0
#define STEP_ISR_STATE       1
#define STEP_ISR_IDLE_COUNT  2
#define STEP_ISR_LEFT        4
#define STEP_ISR_TRAIN_HIGH  5
#define STEP_ISR_TRAINS      6
#define STEP_ISR_STOP        24
#define STEP_ISR_PULSE       25
#define STEP_ISR_CUT         26
#define STEP_ISR_TRAIN_SIZE  9
#define STEP_ISR_SUM         0
#define STEP_ISR_AFTER_SHORT 2
#define STEP_ISR_AFTER_LONG  4
#define STEP_ISR_SHORT_LOW   6
#define STEP_ISR_LONG_LOW    7
#define STEP_ISR_TOP_HIGH    8
#define STEP_ISR_RING_SIZE   512
#define STEP_ISR_HIGH_OFFSET 256

#if !defined(__ASSEMBLER__)
#include <util/atomic.h>

#include "motion/step_engine.h" // struct step_engine

extern struct step_engine step_engines[CONFIG_AXES];
extern struct step_ring step_rings[CONFIG_AXES];

// What an axis's interrupt has done, as of one instant.
static inline struct engine_sample step_isr_sample(uint8_t axis)
{
    const struct step_engine *engine = &step_engines[CONFIG_INDEX(axis)];
    uint8_t tail = 0;
    int8_t left = 0;
    int8_t cut = 0;
    uint16_t idle_count = 0;

    ATOMIC_BLOCK(ATOMIC_FORCEON)
    {
        tail = engine->tail;
        left = engine->left;
        cut = engine->cut;
        idle_count = engine->idle_count;
    }
    return step_engine_sample_of(tail, left, cut, idle_count);
}
#endif
