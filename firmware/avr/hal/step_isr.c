// SPDX-License-Identifier: MIT
// What the step interrupt's assembly and C halves work on.
#include "avr/hal/step_isr.h"

struct step_engine step_engines[CONFIG_AXES];
// The rings lie on 256-byte boundaries, because the linker puts this section first in RAM.
struct step_ring step_rings[CONFIG_AXES]
    __attribute__((section(".step_rings,\"aw\",@nobits;")));

#if CONFIG_AXES > 1
volatile uint8_t step_isr_last[CONFIG_AXES];
volatile uint8_t step_isr_before_low[CONFIG_AXES];
volatile uint8_t step_isr_before_high[CONFIG_AXES];
#endif
