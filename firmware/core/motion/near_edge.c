// SPDX-License-Identifier: MIT
#include "motion/near_edge.h"

#include <stddef.h> // offsetof

#if SEVERAL_AXES && FEATURE_CLOCK_STATISTICS

#if defined(__AVR__)

#include "motion/clock_watch_layout.h"

_Static_assert(offsetof(struct clock_watch, following) == CLOCK_WATCH_FOLLOWING &&
                   offsetof(struct clock_watch, edges) == CLOCK_WATCH_EDGES &&
                   offsetof(struct clock_watch, edge_ticks) == CLOCK_WATCH_EDGE_TICKS &&
                   offsetof(struct clock_watch, next_ticks) == CLOCK_WATCH_NEXT_TICKS &&
                   offsetof(struct clock_watch, near) == CLOCK_WATCH_NEAR &&
                   offsetof(struct clock_watch, near_ticks) == CLOCK_WATCH_NEAR_TICKS &&
                   offsetof(struct clock_watch, pixel) == CLOCK_WATCH_PIXEL &&
                   offsetof(struct clock_watch, divider) == CLOCK_WATCH_DIVIDER &&
                   offsetof(struct clock_watch, phase) == CLOCK_WATCH_PHASE &&
                   offsetof(struct clock_watch, error_ticks) == CLOCK_WATCH_ERROR &&
                   offsetof(struct clock_watch, error_max_ticks) ==
                       CLOCK_WATCH_ERROR_MAX &&
                   offsetof(struct clock_watch, grid) == CLOCK_WATCH_GRID,
               "known to near_edge.S");
_Static_assert(offsetof(struct near_edge, pixel) == 0 &&
                   offsetof(struct near_edge, taken) == 2 &&
                   offsetof(struct near_edge, of_pixel) == 3,
               "near_edge.S returns it in r22..r25");

#else

// Whether the quick way of the account, ledger_capture.S, could place the edge.
static bool is_in_pixel(const struct captured_edge *edge,
                        struct ledger *ledger,
                        struct stream *stream)
{
    if ((edge->notes & ~CAPTURED_EDGE_BACK) != 0 ||
        edge->idle_count != ledger->idle_seen || ledger->train != LEDGER_NO_TRAIN ||
        stream_batch_here(stream) != NULL) {
        return false;
    }
    return ledger_take_pixels(ledger, stream, edge->tail);
}

struct near_edge near_edge_take(const struct captured_edge *edge,
                                struct ledger *ledger,
                                struct stream *stream,
                                struct clock_watch *watch)
{
    struct near_edge near = {.taken = false};

    if (!clock_watch_expects(watch) || !is_in_pixel(edge, ledger, stream)) {
        return near;
    }
    struct engine_sample sample = {.tail = edge->tail, .idle_count = edge->idle_count};
    uint32_t edge_ticks =
        ledger_advance_to_capture(ledger, stream, &sample, edge->notes, edge->ticks) -
        CAPTURED_EDGE_DELAY_TICKS;

    near.taken = clock_watch_near(watch, edge_ticks, &near.pixel, &near.of_pixel);
    return near;
}

#endif

#endif
