// SPDX-License-Identifier: MIT
// The pixel clock input, captured by the timer of axis CONFIG_PIXEL_CLOCK_AXIS.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "motion/step_engine.h" // struct engine_sample

// Ticks from an edge at the pin to the counter value captured for it: two synchroniser stages and
// the edge detector.
#define PIXEL_CLOCK_CAPTURE_DELAY_TICKS 3u

struct pixel_capture {
    uint16_t ticks;              // counter value, from the start of its period
    uint8_t back;                // which period: argument of ledger_period_start()
    struct engine_sample sample; // of that axis, at the capture
};

// True when a capture has not been taken. A sample of that axis taken before this said false is
// not younger than any capture still to come.
bool pixel_clock_waiting(void);

// The oldest capture not yet taken; *lost: another came before it was taken.
bool pixel_clock_take(struct pixel_capture *capture, bool *lost);

// The same for an edge that is of no use; false when there was none.
static inline bool pixel_clock_drop(void)
{
    struct pixel_capture edge;
    bool lost = false;

    return pixel_clock_take(&edge, &lost);
}
