// SPDX-License-Identifier: MIT
// Starts what needs more than memory that reads 0.
#pragma once

// Start settings, axes, faults and the modules between them. Called with interrupts off;
// time_check_start() must follow, and interrupts must be on before an idle period is over.
void board_start(void);
