// SPDX-License-Identifier: MIT
#include "app/motion/clock_edges.h"

#include "app/axes/axes.h"        // axes_*
#include "app/axes/faults.h"      // faults_latch
#include "app/axes/gate.h"        // gate_*
#include "app/axes/mark.h"        // mark_disturb
#include "app/axes/reference.h"   // reference_*
#include "app/axes/token.h"       // token_now
#include "app/motion/seek.h"      // seek_*
#include "app/motion/start.h"     // start_on_edge
#include "app/watch/time_check.h" // time_check_lags
#include "base/apart.h"           // APART
#include "clock/lock_grid.h"      // lock_grid_*
#include "hal/pixel_clock.h"      // pixel_clock_*

#if FEATURE_CLOCK_STATISTICS
// Pixels from the account's newest one to the edge's, less one: 0xFFFF is the newest one itself.
static inline uint16_t pixels_behind(const struct axis *axis, uint16_t pixel)
{
    return (uint16_t)((uint16_t)(pixel - 1u) - (uint16_t)axis->ledger.pixel);
}

// The account of the axis has passed the edge's pixel by more than one, or has yet to come so far
// that errors cannot be noted ahead: it lags, or the line is over. The clock goes on behind a
// line's last pixel: what comes then is not the line's.
static APART void note_elsewhere(uint8_t i, uint16_t pixel, int16_t error_ticks)
{
    struct axis *axis = axes_get(i);

    if (!lifecycle_moving(&axis->life)) {
        return;
    }
    if (pixels_behind(axis, pixel) <= UINT16_MAX / 2u) {
        (void)axes_advance(i, LEDGER_BY_WAYPOINTS);
    }
    if (pixels_behind(axis, pixel) < RECORDS_EARLY) {
        records_note_early(&axis->ledger.records, pixel, error_ticks);
    } else {
        records_note_error(&axis->ledger.records, pixel, error_ticks);
    }
}

// Note the error of a clock edge in the records of the axes. Pixels are counted from a line's own
// line zero, so that only lines with the line zero of the reference may take its errors.
static APART void note_edge_error(uint16_t pixel)
{
    // Read once: the compiler cannot know that the records are elsewhere.
    int16_t error_ticks = reference_watch()->error_ticks;
    uint8_t axes = start_followers();

    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        struct axis *axis = axes_get(i);
        if ((axes & axis_bit(i)) == 0) {
            continue;
        }
        uint16_t behind = pixels_behind(axis, pixel);
        if (behind < RECORDS_EARLY) {
            records_note_early(&axis->ledger.records, pixel, error_ticks);
        } else if (behind == UINT16_MAX && pixel != 0) {
            records_note_last(&axis->ledger.records, error_ticks);
        } else {
            note_elsewhere(i, pixel, error_ticks);
        }
    }
}
#else
static void note_edge_error(uint16_t pixel)
{
    (void)pixel;
}
#endif

// The first axis whose line needs the pixel clock; NO_AXIS if there is none.
static uint8_t first_clocked(void)
{
    uint8_t i = 0;

    while (i < CONFIG_AXES &&
           !(axes_get(i)->clocked && lifecycle_moving(&axes_get(i)->life) &&
             !gate_spares(i))) {
        i++;
    }
    return i;
}

// A clock that rests is no fault: it is gated, and no line needs it.
static inline bool may_rest(void)
{
    return gate_on() && first_clocked() == NO_AXIS;
}

// A line follows the clock, or has its place. Behind the first edge of a burst no line does: those
// that run are over.
static inline bool line_begun(void)
{
    return !token_edge_by_gate() && start_clocked_axis_begun();
}

// Latch a fault of the first axis that needs the pixel clock, if there is one. Axes that wait for
// command `go` tolerate what the clock does; running axes do not.
static void clock_fault(enum fault code, uint16_t argument)
{
    uint8_t axis = first_clocked();

    if (axis == NO_AXIS ||
        (token_held() && (CONFIG_AXES == 1 || !start_clocked_axis_begun()))) {
        return;
    }
    // An edge is placed by the account of an axis, so that the interrupt of this axis must be
    // alive.
    if (CONFIG_AXES > 1 && time_check_lags(CONFIG_PIXEL_CLOCK_AXIS)) {
        faults_latch_underrun(CONFIG_PIXEL_CLOCK_AXIS);
        return;
    }
    (void)axes_advance(axis, LEDGER_EXACTLY);
    faults_latch(code, axis, argument);
}

// A captured edge on its way (clock_edges.h). Its fault is latched last, when all that placed the
// edge is off the stack.
struct clock_edge {
    // When it came, ticks since the timers started.
    uint32_t ticks;
    // What is wrong with it, or FAULT_none.
    enum fault fault;
    // Whether it is one of the clock's, and of a pixel.
    enum edge_kind kind;
    // A line needs the clock.
    bool needed;
    // The clock is gated, no line needs it, and the edge ends a rest.
    bool first;
};

// Edges to come until one is surely next to the one before it: lost edges were lost behind those
// that waited then.
static uint8_t unsure_edges;

// Edges were lost shortly before, so that this edge's distance is no fault of the clock.
static inline bool after_loss(void)
{
    return unsure_edges != 0;
}

// The argument of a fault that an edge has.
static inline uint16_t evidence_of(enum fault fault)
{
    const struct clock_filter *filter = &lock_grid_now()->filter;

    BY_POINTER_SMALL(filter);
    if (fault == FAULT_clock_drifted) {
        return clock_watch_units(filter->period.ticks);
    }
    if (fault == FAULT_clock_hold_over) {
        return filter->hold_over;
    }
    if (FEATURE_GATE && fault == FAULT_clock_edge_lost) {
        return 1;
    }
    return reference_watch()->odd;
}

// A false edge begins the rest again. Behind a burst's first edge any odd distance shows that one
// of the first edges may be false.
static inline bool phase_is_doubtful(uint8_t fresh)
{
    return fresh == CLOCK_FILTER_RESTS ||
           (token_edge_by_gate() && reference_watch()->odd != 0);
}

// Compare a lock with what its lines allow. A clock that is another one than was measured has
// unsettled the filter. A clock that has rested has lost its phase, which no line that has its
// place survives; for others a false edge among the first ones makes it doubtful which edge is
// which.
static inline enum fault judge_lock(void)
{
    uint8_t fresh = lock_grid_now()->filter.fresh;

    if (!reference_settled()) {
        mark_disturb();
        return FAULT_pixel_clock_off;
    }
    if (fresh == 0) {
        return lock_grid_tolerates() ? FAULT_none : FAULT_clock_drifted;
    }
    if (fresh == CLOCK_FILTER_RESTS) {
        mark_disturb();
    }
    if (line_begun()) {
        return FAULT_clock_hold_over;
    }
    return token_edge_named() && phase_is_doubtful(fresh) ? FAULT_pixel_clock_off
                                                          : FAULT_none;
}

// Compare the edge's distance from the one before with what the lines allow.
static inline enum fault judge_distance(void)
{
    if (!after_loss() && reference_watch()->odd == 0) {
        return FAULT_none;
    }
    mark_disturb();
    return after_loss() ? FAULT_none : FAULT_pixel_clock_off;
}

// The edge is the first one of a burst, or may be, which is a fault of the lines that wait. What
// `go` has named stays, and what waits for `go` has no line zero yet.
static inline enum fault begin_burst(enum fault fault)
{
    if (!token_held() && !(token_edge_named() && start_any_waits())) {
        gate_name_zero();
    }
    if (fault != FAULT_none) {
        mark_disturb();
    }
    return fault;
}

// Judge an edge as the first one of a burst, by its lock, or by its distance.
static inline enum fault judge(const struct clock_edge *edge)
{
    if (edge->first) {
        return begin_burst(after_loss() ? FAULT_clock_edge_lost : FAULT_none);
    }
    if (!edge->needed && gate_edge_is_early()) {
        return begin_burst(FAULT_pixel_clock_off);
    }
    return lock_grid_now()->locks ? judge_lock() : judge_distance();
}

// The edge cannot be placed if a command has brought the account past it meanwhile, or if the
// axis's switch was captured too and the order of the two is not known. The next edge serves.
static inline bool is_unplaced(const struct axis *axis,
                               const struct pixel_capture *capture)
{
    return ledger_has_passed(&axis->ledger, &capture->sample) ||
           (CONFIG_AXES > 1 && seek_edge_waits(CONFIG_PIXEL_CLOCK_AXIS));
}

static inline enum fault drop(void)
{
    mark_disturb();
    reference_edge_dropped();
    return gate_on() && gate_begins_unplaced() && first_clocked() == NO_AXIS
               ? begin_burst(FAULT_clock_edge_lost)
               : FAULT_none;
}

// Place an edge in the account of the clock's axis.
static inline void place(struct clock_edge *edge,
                         struct axis *axis,
                         const struct pixel_capture *capture)
{
    edge->ticks = ledger_advance_to_capture(&axis->ledger,
                                            &axis->feed.stream,
                                            &capture->sample,
                                            capture->back,
                                            capture->ticks) -
                  PIXEL_CLOCK_CAPTURE_DELAY_TICKS;
    edge->needed = !gate_on() || first_clocked() != NO_AXIS;
    edge->first = !edge->needed && gate_begins(edge->ticks);
}

// Count an edge that was placed, and note its error in the records.
static inline void note(struct clock_edge *edge)
{
    uint16_t pixel = 0;

    edge->kind = reference_edge(edge->ticks, &pixel);
    if (edge->kind == EDGE_OF_PIXEL) {
        note_edge_error(pixel);
    }
}

// True when lines may start on this edge. Line zero is counted from the newest edge: an older one
// may be too long ago.
static inline bool may_start(const struct clock_edge *edge)
{
    return edge->kind != EDGE_FALSE && edge->fault == FAULT_none &&
           !pixel_clock_waiting();
}

// Take a captured clock edge as far as its fault, if it has one.
static void take_edge(struct clock_edge *edge, const struct pixel_capture *capture)
{
    struct axis *axis = axes_get(CONFIG_PIXEL_CLOCK_AXIS);

    if (is_unplaced(axis, capture)) {
        edge->fault = drop();
        return;
    }
    place(edge, axis, capture);
    note(edge);
    edge->fault = judge(edge);
    if (start_any_waits() && may_start(edge)) {
        start_on_edge(edge->ticks);
    }
}

// Edges that were lost since the last call.
static uint8_t take_lost(void)
{
    // To ask first is worth the flash where there are several axes.
    if (SEVERAL_AXES && !pixel_clock_any_lost()) {
        return 0;
    }
    uint8_t lost = pixel_clock_take_lost();

    if (!pixel_clock_take_crowded() || lost != 0) {
        return lost;
    }
    // So close behind another one it is a glitch, which a lock bridges. Where it may be the first
    // edge of a burst nobody bridges it.
    if (lock_grid_now()->locks && !may_rest()) {
        lock_grid_now()->filter.glitches++;
        return 0;
    }
    return 1;
}

// Edges taken in one round: as many as can wait. A clock faster than the main loop, or noise, must
// not hold it.
#define EDGES_A_ROUND CONFIG_CLOCK_EDGES

// Of lost edges; stays at 255.
static uint8_t sum_of(uint8_t lost, uint8_t more)
{
    uint8_t sum = (uint8_t)(lost + more);

    return sum < more ? UINT8_MAX : sum;
}

// Add the edges that were lost behind those that waited.
static inline uint8_t add_lost(uint8_t lost)
{
    uint8_t lost_now = take_lost();

    if (lost_now == 0) {
        return lost;
    }
    reference_count_lost(lost_now);
    mark_disturb();
    unsure_edges = CONFIG_CLOCK_EDGES + 1u;
    return sum_of(lost, lost_now);
}

// Take one edge, and latch its fault.
static inline void take_this(const struct pixel_capture *capture)
{
    struct clock_edge edge;

    take_edge(&edge, capture);
    if (unsure_edges != 0) {
        unsure_edges--;
    }
    if (edge.fault != FAULT_none) {
        clock_fault(edge.fault, evidence_of(edge.fault));
    }
}

// Take as many edges as wait. Returns the number of those that were lost.
static inline uint8_t take_waiting(void)
{
    struct pixel_capture capture;
    uint8_t lost = 0;

    for (uint8_t left = EDGES_A_ROUND; left != 0 && pixel_clock_take(&capture); left--) {
        lost = add_lost(lost);
        take_this(&capture);
    }
    return lost;
}

// Take captured clock edges. Not inline, so that the captures do not take up stack below the
// decoder of steps.
static APART void take_captures(void)
{
    uint8_t lost = take_waiting();

    // A line that waits needs no edge in particular, unless one is named.
    if (lost != 0 && (token_edge_named() || start_clocked_axis_runs())) {
        clock_fault(FAULT_clock_edge_lost, lost);
    }
}

void clock_edges_await(void)
{
    if (first_clocked() == NO_AXIS && !reference_present()) {
        reference_await_edge();
    }
    if (!start_any_waits()) {
        lock_grid_hold_period();
    }
}

bool clock_edges_allow(const struct axis *axis)
{
    if (gate_on() && axis_waits_for_edge(axis) && !gate_fits()) {
        return false;
    }
    return !lock_grid_now()->locks || !axis_waits_for_edge(axis) || reference_settled();
}

void clock_edges_poll(void)
{
    if (!seek_has_clock_input() && pixel_clock_waiting()) {
        take_captures();
    }
}

// The clock does not run, and has been silent for long enough to say so.
static void miss_clock(void)
{
    const struct clock_filter *filter = &lock_grid_now()->filter;

    if (may_rest()) {
        gate_rest();
        reference_rest();
        return;
    }
    if (reference_present()) {
        mark_disturb();
        reference_rest();
        if (lock_grid_now()->locks) {
            clock_fault(FAULT_clock_hold_over, filter->hold_over);
            return;
        }
    } else if (start_may_wait()) {
        return;
    }
    clock_fault(FAULT_pixel_clock_missing, 0);
}

void clock_edges_miss(void)
{
    if (gate_on() && seek_has_clock_input()) {
        gate_unsure();
        reference_await_edge();
        return;
    }
    if (!pixel_clock_waiting() && reference_overdue()) {
        if (lock_grid_now()->locks && !may_rest() &&
            clock_filter_bridge(&lock_grid_now()->filter)) {
            return;
        }
        miss_clock();
    }
}
