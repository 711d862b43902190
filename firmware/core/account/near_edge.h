// SPDX-License-Identifier: MIT
// An edge of the pixel clock where it was planned, in a pixel of few even steps: nearly every edge
// of a fast clock. It is placed by the account of the clock's axis and compared with the plan of
// the running line in one go, in half the time that the general way takes (ledger.h, clock_watch.h:
// the results are the same). On boards of several axes. Main loop only.
//
//     planned      |         |         |
//     edges        |          |          |     near: the error differs from that of the edge before
//     error        0          1          2     by less than a thirty-second of the period
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "account/ledger.h"     // struct ledger
#include "build_features.h"     // SEVERAL_AXES
#include "clock/clock_watch.h"  // struct clock_watch
#include "ring/captured_edge.h" // struct captured_edge

#if SEVERAL_AXES && FEATURE_CLOCK_STATISTICS

struct near_edge {
    // Number of the pixel edge that it is (0: line zero), if it is one.
    uint16_t pixel;
    // It is taken; watch->edge_ticks is its time, and watch->error_ticks its error.
    bool taken;
    // It is a pixel edge of the reference line.
    bool of_pixel;
};

// Take an edge. Where it is not taken, because it came elsewhere, or the account is in no pixel of
// few even steps, the watch is as before, and the general way serves. The account may have
// advanced, as ledger_advance_to_capture() advances it.
struct near_edge near_edge_take(const struct captured_edge *edge,
                                struct ledger *ledger,
                                struct stream *stream,
                                struct clock_watch *watch);

#endif
