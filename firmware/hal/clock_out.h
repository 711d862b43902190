// SPDX-License-Identifier: MIT
// A pixel clock of the board's own, for a machine that has no other yet: the board makes it on pin
// CLOCK_OUT, and a wire takes it to PIXEL_CLOCK, of this board or of others. Main loop only.
//
// Where CLOCK_OUT is a compare output of the coarse clock's timer, the hardware makes the edges. An
// interrupt moves the compare register on, once a millisecond or twice a period: it lets the step
// interrupts in at once. On other boards that interrupt makes the edges, later by as long as it has
// to wait.
//
// Without FEATURE_CLOCK_OUT nothing of it is there, and the pin is left alone.
#pragma once

#include <stdint.h>

#include "config.h" // FEATURE_CLOCK_OUT

#if FEATURE_CLOCK_OUT

// Make a clock of so many hertz (core/base/clock_out.h) from now on; 0: none, and the pin is an
// input again. The clock goes on undisturbed if it is that already.
void clock_out_set(uint16_t hz);

#else

static inline void clock_out_set(uint16_t hz)
{
    (void)hz;
}

#endif
