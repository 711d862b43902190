// SPDX-License-Identifier: MIT
// A pixel clock of the board's own, for a board that has no other: timer 2 makes it on pin
// CLOCK_OUT, and a wire takes it to PIXEL_CLOCK, of this board or of others. The edges are the
// hardware's, without an interrupt, so that they cost the step engines nothing and keep their
// distance whatever the program does. Main loop only.
//
// Without FEATURE_CLOCK_OUT nothing of it is there, and the pin is left alone.
#pragma once

#include <stdint.h>

#include "build_features.h" // FEATURE_CLOCK_OUT

#if FEATURE_CLOCK_OUT

// Make a clock of so many hertz (core/clock/clock_out_plan.h) from now on; 0: none, and the pin is
// an input again. The clock goes on undisturbed if it is that already.
void clock_out_set(uint16_t hz);

// Look after a clock that is too slow for the hardware alone. Once a round, and at least every
// 8 ms: a change of level comes a match later, up to 16 ms, for a call that is missing.
void clock_out_poll(void);

#else

static inline void clock_out_set(uint16_t hz)
{
    (void)hz;
}

static inline void clock_out_poll(void)
{
}

#endif
