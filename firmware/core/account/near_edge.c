// SPDX-License-Identifier: MIT
#include "account/near_edge.h"

#include <stddef.h> // offsetof

#if SEVERAL_AXES && FEATURE_CLOCK_STATISTICS

#if defined(__AVR__)

_Static_assert(offsetof(struct near_edge, pixel) == 0 &&
                   offsetof(struct near_edge, taken) == 2 &&
                   offsetof(struct near_edge, of_pixel) == 3,
               "near_edge.S returns it in r22..r25");

#else

struct near_edge near_edge_take(const struct captured_edge *edge,
                                struct ledger *ledger,
                                struct stream *stream,
                                struct clock_watch *watch)
{
    struct near_edge near = {.taken = false};
    struct engine_sample sample = {.tail = edge->tail, .idle_count = edge->idle_count};
    uint32_t ticks = 0;

    if ((edge->notes & ~CAPTURED_EDGE_BACK) != 0 || !clock_watch_expects(watch) ||
        !ledger_capture_in_pixel(
            ledger, stream, &sample, edge->notes, edge->ticks, &ticks)) {
        return near;
    }
    near.taken = clock_watch_near(
        watch, ticks - CAPTURED_EDGE_DELAY_TICKS, &near.pixel, &near.of_pixel);
    return near;
}

#endif

#endif
