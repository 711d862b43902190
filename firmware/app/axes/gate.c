// SPDX-License-Identifier: MIT
#include "app/axes/gate.h"

#if FEATURE_GATE

#include "app/axes/axes.h"         // axes_*
#include "app/axes/faults.h"       // faults_*
#include "app/axes/mark.h"         // mark_now
#include "app/axes/reference.h"    // reference_*
#include "app/axes/token.h"        // token_*
#include "app/settings/settings.h" // settings_now
#include "clock/lock_grid.h"       // lock_grid_now

static bool
    rests; // the clock has been silent for so long that the next edge begins a burst
static uint8_t unjudged; // axes with a line that is over, whose burst may not be

bool gate_on(void)
{
    return settings_now()->gate_edges != 0;
}

// The phase of a lock is new at the first edge: no line may have its place until it is trusted.
bool gate_fits(void)
{
    uint16_t least = reference_place_edges();

    if (lock_grid_now()->locks) {
        least = (uint16_t)(least + CLOCK_FILTER_FRESH_EDGES);
    }
    return !gate_on() || settings_now()->gate_edges >= least;
}

// The axis runs, and its interrupt has been given all of its line's steps.
static bool is_over(uint8_t i)
{
    const struct axis *axis = axes_get(i);

    if (axis->life.state != AXIS_RUNNING || axis->phase != DECODE_OUTSIDE) {
        return false;
    }
    (void)axes_advance(i, LEDGER_EXACTLY);
    return axis_ring_fill(axis) == 0;
}

// Once a burst has named line zero, nothing may happen to its edges, for lines still to be armed as
// well.
bool gate_spares(uint8_t axis)
{
    return gate_on() && !token_edge_by_gate() &&
           (axes_get(axis)->life.state == AXIS_ARMED || is_over(axis));
}

// The number of the edge that ends the line. Of lines that follow each other without a pause only
// the last one is counted. Nobody asks for the line zero of a line that is over.
void gate_line_done(uint8_t axis)
{
    struct axis *done = axes_get(axis);

    if (gate_on() && done->clocked) {
        done->zero_ticks =
            mark_now()->zero_edge + done->ledger.pixel * lock_grid_now()->divider;
        unjudged |= axis_bit(axis);
    }
}

// The burst is over: each line must have had the edge that ends it. One that was bridged has not
// come.
static void judge_ends(void)
{
    const struct lock_grid *grid = lock_grid_now();
    uint16_t last = reference_number();

    if (grid->locks) {
        last = (uint16_t)(last - grid->filter.bridged);
    }
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        if (is_over(i)) {
            gate_line_done(i);
        }
        if ((unjudged & axis_bit(i)) != 0 &&
            (int16_t)(last - (uint16_t)axes_get(i)->zero_ticks) < 0) {
            faults_latch_plain(FAULT_pixel_clock_missing, i);
        }
    }
    unjudged = 0;
}

void gate_rest(void)
{
    rests = true;
    judge_ends();
}

void gate_unsure(void)
{
    rests = false;
}

// The edge lies farther behind the one before than jitter explains.
static bool is_late(uint32_t edge_ticks)
{
    uint32_t period_ticks = reference_period()->whole_ticks;

    return reference_present() &&
           edge_ticks - reference_watch()->edge_ticks > period_ticks + period_ticks / 16u;
}

bool gate_begins(uint32_t edge_ticks)
{
    if (!gate_begins_unplaced() && !is_late(edge_ticks)) {
        return false;
    }
    judge_ends();
    // The phase is new, the period is not.
    reference_rest();
    return true;
}

bool gate_begins_unplaced(void)
{
    bool rested = rests;

    rests = false;
    return rested;
}

bool gate_edge_is_early(void)
{
    uint16_t odd = reference_watch()->odd;

    return odd != 0 && odd < reference_period()->whole_ticks >> 8;
}

void gate_name_zero(void)
{
    token_gate_edge((uint16_t)(reference_number() + settings_now()->gate_edges));
}

// The front line of the axis waits for the clock. A line longer than the queue is no line yet.
static bool next_waits(const struct axis *axis)
{
    return axis->clocked && axis->whole_lines != 0 && axis_waits_for_edge(axis);
}

bool gate_overruns(void)
{
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        const struct axis *axis = axes_get(i);
        if (token_edge_by_gate() && axis->life.state == AXIS_RUNNING &&
            next_waits(axis)) {
            return true;
        }
    }
    return false;
}

bool gate_arms_next(uint8_t axis)
{
    return gate_on() && next_waits(axes_get(axis)) && !faults_any();
}

#endif
