// SPDX-License-Identifier: MIT
// Starts what needs more than memory that reads 0.
//
//     board_start()
//         store_load()              settings: stored ones or defaults
//         seek_start()              no seek
//         axes_start()              every axis EMPTY, at position 0
//         limits_apply_settings()   pixel period, limits, reversal times, the board's own clock
#pragma once

// Start settings, axes, faults and the modules between them. Called with interrupts off;
// time_check_start() must follow, and interrupts must be on before an idle period is over.
void board_start(void);
