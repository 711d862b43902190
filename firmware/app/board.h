// SPDX-License-Identifier: MIT
// The board at its beginning: what needs more than memory that reads 0.
#pragma once

// Settings, axes, faults and what stands between them. Interrupts off; time_check_start() must
// follow, and interrupts on before an idle period is over.
void board_start(void);
