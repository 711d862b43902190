// SPDX-License-Identifier: MIT
#pragma once

void step_isr_overflow(void);
void step_isr_compare_a(void);
