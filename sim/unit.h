// SPDX-License-Identifier: MIT
//
// Runs a test image to its end, which is a sleep with interrupts off. The image's text from its
// UART goes to standard output; its verdict in GPIOR0 becomes the exit status. An image that does
// not end has failed.
#pragma once

#include "bench.h"

#define UNIT_NO_VERDICT 99 // exit status if the image does not end

// Runs the first board for at most limit_ms of simulated time. Returns the exit status.
int unit_run(struct bench *bench, uint64_t limit_ms);
