// SPDX-License-Identifier: MIT
// Every module of the board at its beginning.
#pragma once

// Settings, axes, faults and what stands between them. Interrupts off; time_check_start() must
// follow, and interrupts on before an idle period is over.
void board_start(void);
