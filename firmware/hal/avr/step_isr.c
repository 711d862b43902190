// SPDX-License-Identifier: MIT
// What the step interrupt's assembly and C halves work on.
#include "hal/avr/step_isr.h"

#include <stddef.h> // offsetof

#define KNOWN(expression, value)                                                         \
    _Static_assert((expression) == (value), "known to step_isr.S")
KNOWN(sizeof(struct step_engine), STEP_ISR_ENGINE_SIZE);
KNOWN(offsetof(struct step_engine, tail), STEP_ISR_TAIL);
KNOWN(offsetof(struct step_engine, state), STEP_ISR_STATE);
KNOWN(offsetof(struct step_engine, idle_count), STEP_ISR_IDLE_COUNT);
KNOWN(offsetof(struct step_engine, left), STEP_ISR_LEFT);
KNOWN(offsetof(struct step_engine, train_high), STEP_ISR_TRAIN_HIGH);
KNOWN(offsetof(struct step_engine, trains), STEP_ISR_TRAINS);
KNOWN(offsetof(struct step_engine, stop), STEP_ISR_STOP);
KNOWN(offsetof(struct step_engine, pulse), STEP_ISR_PULSE);
KNOWN(offsetof(struct step_engine, cut), STEP_ISR_CUT);
KNOWN(sizeof(struct pulse_train), STEP_ISR_TRAIN_SIZE);
KNOWN(offsetof(struct pulse_train, sum), STEP_ISR_SUM);
KNOWN(offsetof(struct pulse_train, after_short), STEP_ISR_AFTER_SHORT);
KNOWN(offsetof(struct pulse_train, after_long), STEP_ISR_AFTER_LONG);
KNOWN(offsetof(struct pulse_train, short_low), STEP_ISR_SHORT_LOW);
KNOWN(offsetof(struct pulse_train, long_low), STEP_ISR_LONG_LOW);
KNOWN(offsetof(struct pulse_train, top_high), STEP_ISR_TOP_HIGH);
KNOWN(sizeof(struct step_ring), STEP_ISR_RING_SIZE);
KNOWN(offsetof(struct step_ring, high), STEP_ISR_HIGH_OFFSET);

struct step_engine step_engines[CONFIG_AXES];
// The rings lie on 256-byte boundaries, because the linker puts this section first in RAM.
struct step_ring step_rings[CONFIG_AXES]
    __attribute__((section(".step_rings,\"aw\",@nobits;")));

#if CONFIG_AXES > 1
volatile uint8_t step_isr_last[CONFIG_AXES];
volatile uint8_t step_isr_before_low[CONFIG_AXES];
volatile uint8_t step_isr_before_high[CONFIG_AXES];
#endif
