// SPDX-License-Identifier: MIT
#include "app/motion/seek.h"

#include "app/axes/axes.h"      // axes_*
#include "app/axes/faults.h"    // faults_*
#include "app/axes/reference.h" // reference_*
#include "app/watch/inputs.h"   // inputs_*
#include "base/apart.h"         // APART
#include "hal/clock.h"          // clock_now_units
#include "hal/step_timer.h"     // step_timer_unpark, STEP_TIMER_EDGE_TICKS
#include "hal/switches.h"       // switch_capture_*

#if FEATURE_HOMING

static struct seek seek;

void seek_start(void)
{
    seek = (struct seek){.axis = NO_AXIS};
    switch_capture_stop();
}

const struct seek *seek_now(void)
{
    return &seek;
}

// The axis that seeks. Only valid during a seek.
static uint8_t seeking_axis(void)
{
    return CONFIG_AXES == 1 ? 0 : seek.axis;
}

void seek_begin(uint8_t axis, bool opening)
{
    seek = (struct seek){
        .axis = CONFIG_INDEX(axis),
        .opening = opening,
        .trip_axis = CONFIG_INDEX(axis),
        .trip_code = TRIP_NONE,
    };
    if (CONFIG_AXES == 1) {
        reference_rest(); // the one capture serves the switch: clock edges are not seen meanwhile
    }
    if (CONFIG_AXES > 1) {
        (void)step_timer_unpark(axis);
        (void)step_timer_unpark(CONFIG_SWITCH_CAPTURE_AXIS);
    }
    switch_capture_start(CONFIG_INDEX(axis), opening != inputs_home_inverted());
}

// Note where the seeking axis was at the switch's edge. The accounts of the axis that captures and
// of the axis that seeks are brought exactly to the instant of the capture, so that the edge lies
// in one of the last three periods.
static void note_switch_edge(const struct switch_capture *capture)
{
    struct axis *clock = axes_get(CONFIG_SWITCH_CAPTURE_AXIS);
    struct axis *axis = axes_get(seeking_axis());

    ledger_advance(
        &clock->ledger, &clock->feed.stream, &capture->edge.sample, LEDGER_EXACTLY);
    if (CONFIG_AXES > 1 && axis != clock) {
        ledger_advance(
            &axis->ledger, &axis->feed.stream, &capture->seeker, LEDGER_EXACTLY);
    }
    seek.ticks =
        ledger_period_start(&clock->ledger, &clock->feed.stream, capture->edge.back) +
        capture->edge.ticks - SWITCH_CAPTURE_DELAY_TICKS;
    uint8_t after = ledger_steps_after(
        &axis->ledger, &axis->feed.stream, seek.ticks, (uint8_t)STEP_TIMER_EDGE_TICKS);
    seek.position_steps = ledger_position(&axis->ledger) +
                          (axis->ledger.negative ? after : -(int16_t)after);
    seek.captured_units = (uint16_t)clock_now_units();
    seek.captured = true;
}

// Drop a clock edge that waits. Its sample of the seeking axis may be older than the sample of the
// switch's edge, and an edge cannot be placed once the account has passed its sample.
static void drop_clock_edge(void)
{
    if (pixel_clock_drop()) {
        reference_edge_dropped();
    }
}

// True when no command has brought the accounts past the samples of this capture.
static bool is_new(const struct switch_capture *capture)
{
    return !ledger_has_passed(&axes_get(CONFIG_SWITCH_CAPTURE_AXIS)->ledger,
                              &capture->edge.sample) &&
           (CONFIG_AXES == 1 ||
            !ledger_has_passed(&axes_get(seeking_axis())->ledger, &capture->seeker));
}

// Take a captured edge of the switch. Not inline, so that the capture does not take up stack below
// the decoder of steps.
static APART void take_edge(void)
{
    struct switch_capture capture;

    if (!switch_capture_take(&capture)) {
        return;
    }
    // The order matters: a clock edge that comes after the switch's edge was taken is newer than
    // it.
    if (CONFIG_AXES > 1 && seeking_axis() == CONFIG_PIXEL_CLOCK_AXIS) {
        drop_clock_edge();
    }
    if (seek.captured) {
        // A bouncing switch makes more edges. The first edge gives the position; later ones restart
        // the time after which that edge counts as a disturbance.
        seek.captured_units = (uint16_t)clock_now_units();
    } else if (seek.trip_code == TRIP_NONE && is_new(&capture)) {
        note_switch_edge(&capture);
    }
}

// End the motion when the filtered switch is as sought, or forget an edge that was a disturbance.
static void judge_switch(void)
{
    if (inputs_home_closed(seeking_axis()) != seek.opening) {
        seek.trip_code = TRIP_ALREADY;
        if (seek.captured) {
            seek.trip_code = seek.opening ? TRIP_OPENED : TRIP_CLOSED;
        }
        segment_source_trip(&axes_get(seeking_axis())->line.source);
    } else if (seek.captured && inputs_lasted(seek.captured_units) &&
               inputs_settled(seeking_axis())) {
        seek.captured = false; // a disturbance: the switch is as it was
    }
}

// True when nothing of the seek is left because the axis was stopped or its line discarded.
static APART bool at_rest(uint8_t state)
{
    return state == AXIS_EMPTY || state == AXIS_STOPPING;
}

static void end_seek(void)
{
    uint8_t axis = seeking_axis();

    seek.axis = NO_AXIS;
    switch_capture_stop();
    if (seek.trip_code == TRIP_NONE && !faults_any() &&
        !at_rest(axes_get(axis)->life.state)) {
        faults_latch_plain(seek.opening ? FAULT_home_stuck : FAULT_home_not_found, axis);
    }
}

void seek_poll(void)
{
    if (seek.axis == NO_AXIS) {
        return;
    }
    uint8_t axis = seeking_axis();
    const struct lifecycle *life = &axes_get(axis)->life;

    if (at_rest(life->state) || life->state == AXIS_FAULT) {
        end_seek();
        return;
    }
    bool moving = lifecycle_moving(life);

    // The order matters: a level that is read after an edge was taken is not older than that edge.
    take_edge();
    inputs_poll(axis, FEATURE_SHARED_SWITCH && seek.captured);
    if (seek.trip_code == TRIP_NONE) {
        judge_switch();
    }
    // A seek is decoded only a little ahead of the account, so that the account must keep up.
    (void)axes_advance(axis, LEDGER_EXACTLY);
    if (!moving) {
        end_seek();
    }
}

bool seek_has_clock_input(void)
{
    return CONFIG_PIXEL_CLOCK_AXIS == CONFIG_SWITCH_CAPTURE_AXIS && seek.axis != NO_AXIS;
}

bool seek_uses_switch(uint8_t axis)
{
    return seek.axis == axis && seek.captured;
}

bool seek_edge_waits(uint8_t axis)
{
    return seek.axis == axis && switch_capture_waiting();
}

bool seek_needs_interrupts(uint8_t axis)
{
    return seek.axis != NO_AXIS &&
           (axis == seek.axis || axis == CONFIG_SWITCH_CAPTURE_AXIS);
}

bool seek_can_zero(uint8_t axis)
{
    return seek.axis == NO_AXIS && seek.trip_axis == CONFIG_INDEX(axis) &&
           (seek.trip_code == TRIP_CLOSED || seek.trip_code == TRIP_OPENED);
}

void seek_zero(uint8_t axis)
{
    // The account of an axis at rest already contains every step. Following the step interrupt now
    // could bring the account past a pixel clock edge that was captured and waits.
    ledger_zero(&axes_get(axis)->ledger, seek.position_steps);
    seek.position_steps = 0;
}

#endif
