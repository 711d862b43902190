// SPDX-License-Identifier: MIT
// Coarse time for silences and time-outs; never for motion.
#pragma once

#include <stdint.h>

void clock_start(void);

// Units of 4 us since clock_start(); wraps after 4.7 hours.
uint32_t clock_now_4us(void);
