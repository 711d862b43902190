// SPDX-License-Identifier: MIT
// The step interrupts, which run inside the explored firmware.
#pragma once

#include <stdint.h>

void step_isr_overflow(uint8_t axis);
void step_isr_compare_a(uint8_t axis);
// The pixel clock's capture; of boards with several axes.
void capture_isr(void);
