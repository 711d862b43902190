// SPDX-License-Identifier: MIT
//
// Runs a test image to its end: its UART text to standard output, its verdict (GPIOR0) as the exit
// status. An image that does not come to an end (sleep with interrupts off) has failed.
#pragma once

#include "bench.h"

#define UNIT_NO_VERDICT 99 // exit status of a run without an end

// At most limit_ms of simulated time. Returns the exit status.
int unit_run(struct bench *bench, uint64_t limit_ms);
