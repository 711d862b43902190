// SPDX-License-Identifier: MIT
// The board's digital pins as a whole.
#pragma once

// Directions and levels of every pin: STEP low, drivers off, inputs pulled up. Call early.
void pins_start(void);
