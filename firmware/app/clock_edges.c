// SPDX-License-Identifier: MIT
#include "app/clock_edges.h"

#include "app/axes.h"        // axes_*
#include "app/faults.h"      // faults_latch
#include "app/reference.h"   // reference_*
#include "app/seek.h"        // seek_*
#include "app/start.h"       // start_on_edge
#include "app/time_check.h"  // time_check_lags
#include "app/token.h"       // token_now
#include "base/apart.h"      // APART
#include "hal/pixel_clock.h" // pixel_clock_take

#if FEATURE_CLOCK_STATISTICS
// Pixels are counted from a line's own zero: only lines that share the reference's may take its
// error.
static void note_edge_error(uint32_t pixel)
{
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        if (axes_get(i)->zero_ticks == reference_watch()->zero_ticks) {
            ledger_note_edge_error(
                &axes_get(i)->ledger, pixel, reference_watch()->error_ticks);
        }
    }
}
#else
static void note_edge_error(uint32_t pixel)
{
    (void)pixel;
}
#endif

// The first axis whose line needs the clock, NO_AXIS if none.
static uint8_t first_clocked(void)
{
    uint8_t i = 0;

    while (i < CONFIG_AXES &&
           !(axes_get(i)->clocked && lifecycle_moving(&axes_get(i)->life))) {
        i++;
    }
    return i;
}

// A fault of the first axis that needs the clock, if there is one. Those that wait for go have
// patience with the clock; those that run have not.
static void clock_fault(enum fault code, uint16_t argument)
{
    uint8_t axis = first_clocked();

    if (axis == NO_AXIS ||
        (token_now() != 0 && (CONFIG_AXES == 1 || !start_clocked_axis_runs()))) {
        return;
    }
    // An edge is placed by the account of an axis whose interrupt may not come any more.
    if (CONFIG_AXES > 1 && time_check_lags(CONFIG_PIXEL_CLOCK_AXIS)) {
        faults_latch_underrun(CONFIG_PIXEL_CLOCK_AXIS);
        return;
    }
    (void)axes_follow(axis);
    faults_latch(code, axis, argument);
}

// Not inline: what a capture takes of the stack would lie below the decoder of steps.
static APART void take_capture(void)
{
    struct axis *axis = axes_get(CONFIG_PIXEL_CLOCK_AXIS);
    struct pixel_capture capture;
    uint32_t pixel = 0;
    bool lost = false;

    if (!pixel_clock_take(&capture, &lost)) {
        return;
    }
    // A command may have had the axis accounted for meanwhile, or its switch was captured too and
    // it is not known which was first: the next edge will do.
    if (ledger_has_passed(&axis->ledger, &capture.sample) ||
        (CONFIG_AXES > 1 && seek_edge_waits(CONFIG_PIXEL_CLOCK_AXIS))) {
        reference_edge_dropped();
        return;
    }
    ledger_follow(&axis->ledger, &axis->feed, &capture.sample);
    uint32_t edge_ticks =
        ledger_capture_ticks(&axis->ledger, &axis->feed, capture.back, capture.ticks) -
        PIXEL_CLOCK_CAPTURE_DELAY_TICKS;
    if (reference_edge(edge_ticks, &pixel)) {
        note_edge_error(pixel);
    }
    if (lost) {
        clock_fault(FAULT_clock_edge_lost, 0);
    } else if (reference_watch()->odd != 0) {
        clock_fault(FAULT_pixel_clock_off, reference_watch()->odd);
    }
    start_on_edge(edge_ticks);
}

void clock_edges_await(void)
{
    if (first_clocked() == NO_AXIS && !reference_present()) {
        reference_await_edge();
    }
}

void clock_edges_poll(void)
{
    if (!seek_has_clock_input()) {
        take_capture();
    }
}

void clock_edges_miss(void)
{
    if (reference_overdue()) {
        reference_rest();
        clock_fault(FAULT_pixel_clock_missing, 0);
    }
}
