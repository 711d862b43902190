// SPDX-License-Identifier: MIT
#include "hal/pixel_clock.h"

#include "config.h" // CONFIG_*, BOARD_PIXEL_CLOCK_TIMER
#include "hal/avr/capture.h"

#define PIXEL_CLOCK_HANDLER(timer)                                                       \
    CAPTURE_HANDLER(pixel_clock,                                                         \
                    timer,                                                               \
                    CONFIG_PIXEL_CLOCK_AXIS,                                             \
                    CAPTURE_PIXEL_CLOCK_BUSY,                                            \
                    CAPTURE_PIXEL_CLOCK_OVERRUN)
PIXEL_CLOCK_HANDLER(BOARD_PIXEL_CLOCK_TIMER)

bool pixel_clock_waiting(void)
{
    return pixel_clock.waiting;
}

bool pixel_clock_take(struct pixel_capture *capture, bool *lost)
{
    if (!capture_take(
            &pixel_clock, capture, CONFIG_PIXEL_CLOCK_AXIS, CAPTURE_PIXEL_CLOCK_BUSY)) {
        return false;
    }
    *lost = capture_lost(CAPTURE_PIXEL_CLOCK_OVERRUN);
    return true;
}
