// SPDX-License-Identifier: MIT
#pragma once

void step_isr_overflow(void);
