// SPDX-License-Identifier: MIT
// Bits of GPIOR0, which SBI, CBI, SBIC and SBIS reach: flags between interrupts and main loop.
// Included by assembly too.
#pragma once

// BUSY: from an edge on, of the pixel clock until its handler has ended, of a switch until the main
// loop has taken it. OVERRUN: another edge came meanwhile.
#define FLAG_PIXEL_CLOCK_BUSY    0
#define FLAG_PIXEL_CLOCK_OVERRUN 1
#define FLAG_SWITCH_BUSY         2
#define FLAG_SWITCH_OVERRUN      3
// The pixel clock's handler found the overflow flag of its timer set.
#define FLAG_PIXEL_CLOCK_WRAPPED 4
// With one axis: and once more, behind the period that began then.
#define FLAG_PIXEL_CLOCK_WRAPPED_TWICE 6
// With several axes: the edge that waits for the handler has come in the period whose interrupt was
// served last.
#define FLAG_PIXEL_CLOCK_BEFORE 6
// Another edge of the pixel clock has come since its handler began.
#define FLAG_PIXEL_CLOCK_SECOND 5
// The interrupt of timer 0 has cleared its flag and not counted yet. With one axis nobody asks.
#define FLAG_CLOCK_COUNTING 7
