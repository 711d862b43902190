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
