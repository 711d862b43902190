// SPDX-License-Identifier: MIT
// What the step interrupt's assembly and C halves share. Included by both.
//
// The assembly handler (step_isr.S) makes single periods and periods of trains; C takes the rest.
// Both work on the same struct step_engine, whose offsets the build takes from the C compiler
// (avr/layout.c).
#pragma once

#include "base/literal.h"    // UNSIGNED
#include "config.h"          // CONFIG_AXES
#include "ring/step_codes.h" // STEP_HIGH_*, STEP_IDLE_TICKS, STEP_STATE_*

// In OCRnB: above every TOP, so that the timer finds no match and STEP stays low.
#define QUIET_TICKS UNSIGNED(0xFFFF)

// In step_isr_before_high: nothing is known of the interval before.
#define STEP_ISR_UNKNOWN 0xFF

#if !defined(__ASSEMBLER__)
#include <util/atomic.h>

#include "ring/step_engine.h" // struct step_engine

// The state of each axis's interrupt, and the ring that it reads. The interrupt of the axis owns
// the engine; the main loop samples it, or changes it with the step interrupt off.
extern struct step_engine step_engines[CONFIG_AXES];
extern struct step_ring step_rings[CONFIG_AXES];

#if CONFIG_AXES > 1
// Of each axis: low byte of the TOP that was loaded last, if a train's was; else 0. The high byte
// is the train's, STEP_ISR_TRAIN_HIGH. Where a train follows one with another high byte the last
// TOP is noted in two parts and step_isr_last is 0 (step_catch_up.inc).
extern volatile uint8_t step_isr_last[CONFIG_AXES];
extern volatile uint8_t step_isr_before_low[CONFIG_AXES];
extern volatile uint8_t step_isr_before_high[CONFIG_AXES];
#endif

// An axis's engine. With several axes the address is computed here, ahead of what the caller does
// with interrupts off.
static inline struct step_engine *step_isr_engine(uint8_t axis)
{
    struct step_engine *engine = &step_engines[CONFIG_INDEX(axis)];

#if CONFIG_AXES > 1
    __asm__ volatile("" : "+b"(engine));
#endif
    return engine;
}

// What an axis's interrupt has done, as of one instant. Called with interrupts on: they are off for
// the few cycles of the reads and on afterwards.
static inline struct engine_sample step_isr_sample(uint8_t axis)
{
    const struct step_engine *engine = step_isr_engine(axis);
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
