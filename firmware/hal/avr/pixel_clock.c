// SPDX-License-Identifier: MIT
#include "hal/pixel_clock.h"

#include "config.h" // CONFIG_*
#include "hal/avr/capture.h"

#if defined(CONFIG_BOARD_UNO)
CAPTURE_HANDLER(pixel_clock,
                1,
                CONFIG_PIXEL_CLOCK_AXIS,
                CAPTURE_PIXEL_CLOCK_BUSY,
                CAPTURE_PIXEL_CLOCK_OVERRUN)
#else
CAPTURE_HANDLER(pixel_clock,
                5,
                CONFIG_PIXEL_CLOCK_AXIS,
                CAPTURE_PIXEL_CLOCK_BUSY,
                CAPTURE_PIXEL_CLOCK_OVERRUN)
#endif

bool pixel_clock_waiting(void)
{
    return pixel_clock.waiting;
}

bool pixel_clock_take(struct pixel_capture *capture, bool *lost)
{
    if (!capture_take(&pixel_clock, capture, CAPTURE_PIXEL_CLOCK_BUSY)) {
        return false;
    }
    *lost = capture_lost(CAPTURE_PIXEL_CLOCK_OVERRUN);
    return true;
}
