// SPDX-License-Identifier: MIT
#include "app/round.h"

#include "app/drivers.h" // drivers_poll
#include "app/inputs.h"  // inputs_poll
#include "app/machine.h" // machine_*
#include "app/safety.h"  // safety_poll
#include "app/seek.h"    // seek_*
#include "app/start.h"   // start_on_edge, start_poll
#include "app/store.h"   // store_poll
#include "app/time_check.h"
#include "app/witness.h"     // witness_poll
#include "hal/clock.h"       // clock_now_units
#include "hal/cpu.h"         // cpu_section
#include "hal/estop.h"       // estop_latched
#include "hal/pixel_clock.h" // pixel_clock_take
#include "hal/step_timer.h"  // step_timer_*

// Steps decoded in one round; a round must stay short beside a serial frame's silence.
#define DECODE_BUDGET  (CONFIG_AXES == 1 ? 120u : 240u)
#define DECODE_AT_ONCE 120u
#define DECODE_CALLS   3u // where there are several axes
// While an axis waits for its release, a moment of a few milliseconds that must not be missed.
#define DECODE_BUDGET_STARTING 12u
// Rounds in which every axis's switches are looked at once; an axis that seeks, in every round.
#define INPUT_TURNS 4u

// An axis's account may lag so many entries behind between its turns, one every so many rounds.
#define FOLLOW_ENTRIES 64u
#define TURN_ROUNDS    8u

static void take_underruns(void)
{
    for (uint8_t i = 0; step_timer_underrun() && i < CONFIG_AXES; i++) {
        if (step_timer_take_underrun(i)) {
            machine_underrun(i);
        }
    }
}

// The emergency stop halts an axis before this round has heard of it.
static enum fault why_halted(const struct axis *axis)
{
    if (estop_latched()) {
        return FAULT_estop;
    }
    return axis->dry ? FAULT_starved : FAULT_decoder_late;
}

// An interrupt that came too late halts its axis as well, perhaps since underruns were last looked
// for.
static void name_halt(uint8_t i)
{
    take_underruns();
    if (machine_axis(i)->state == AXIS_RUNNING) {
        (void)machine_follow(i);
        machine_fault(why_halted(machine_axis(i)), i, 0);
    }
}

// A running axis that halted or came to the end of its line.
static void supervise_running(uint8_t i)
{
    struct axis *axis = machine_axis(i);

    if (step_timer_state(i) == STEP_ENGINE_HALTED) {
        name_halt(i);
    } else if (!axis->in_line && axis_ring_fill(axis) == 0 &&
               step_timer_state(i) == STEP_ENGINE_IDLE) {
        machine.clocked &= (uint8_t)~axis_bit(i);
        axis_line_finished(axis);
    }
}

static void supervise(uint8_t i)
{
    if (machine_axis(i)->state == AXIS_RUNNING) {
        supervise_running(i);
        return;
    }
    if (machine.stopping != 0 && (machine.stopping & axis_bit(i)) != 0) {
        machine_discard(i);
    }
    witness_poll(i);
}

// Now and then one axis after the other; out of turn where much has happened: a look costs more
// than what there is to see after a few steps.
static void follow_in_turn(void)
{
    uint8_t due = CONFIG_AXES;

    machine.turn++;
    if (machine.turn % TURN_ROUNDS == 0) {
        due = machine.turn / TURN_ROUNDS % CONFIG_AXES;
    }
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        const struct axis *axis = machine_axis(i);
        uint8_t behind = (uint8_t)(step_timer_tail(i) - axis->ledger.retired);
        // Full marks keep the decoder from the next pixel.
        if (i == due || (CONFIG_AXES > 1 && axis->awaits_run) ||
            behind >= FOLLOW_ENTRIES || feed_marks_full(&axis->feed)) {
            machine_follow_due(i);
        }
    }
}

// Pixels are counted from a line's own zero: only lines that share the reference's may take its
// error.
static void note_edge_error(uint32_t pixel)
{
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        if (machine_axis(i)->zero_ticks == machine.watch.zero_ticks) {
            ledger_note_edge_error(
                &machine_axis(i)->ledger, pixel, machine.watch.error_ticks);
        }
    }
}

// A fault of the first axis that needs the clock, if there is one. Those that wait for go have
// patience with the clock; those that run have not.
static void clock_fault(enum fault code, uint16_t argument)
{
    uint8_t axis = 0;

    if (machine.clocked == 0 ||
        (machine.token != 0 && (CONFIG_AXES == 1 || !start_clocked_axis_runs()))) {
        return;
    }
    while (CONFIG_AXES > 1 && (machine.clocked & axis_bit(axis)) == 0) {
        axis++;
    }
    // An edge is placed by the account of an axis whose interrupt may not come any more.
    if (CONFIG_AXES > 1 && time_check_lags(CONFIG_PIXEL_CLOCK_AXIS)) {
        machine_underrun(CONFIG_PIXEL_CLOCK_AXIS);
        return;
    }
    (void)machine_follow(axis);
    machine_fault(code, axis, argument);
}

static void take_capture(void)
{
    struct axis *axis = machine_axis(CONFIG_PIXEL_CLOCK_AXIS);
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
        machine_edge_dropped();
        return;
    }
    ledger_follow(&axis->ledger, &axis->feed, &capture.sample);
    uint32_t edge_ticks =
        ledger_capture_ticks(&axis->ledger, &axis->feed, capture.back, capture.ticks) -
        PIXEL_CLOCK_CAPTURE_DELAY_TICKS;
    machine.edge_seen_units = clock_now_units();
    if (clock_watch_edge(&machine.watch, &machine.period, edge_ticks, &pixel)) {
        note_edge_error(pixel);
    }
    if (lost) {
        clock_fault(FAULT_clock_edge_lost, 0);
    } else if (machine.watch.odd != 0) {
        clock_fault(FAULT_pixel_clock_off, machine.watch.odd);
    }
    start_on_edge(edge_ticks);
}

static void watch_clock(void)
{
    if (clock_now_units() - machine.edge_seen_units > machine_clock_patience_units()) {
        clock_watch_rest(&machine.watch);
        clock_fault(FAULT_pixel_clock_missing, 0);
    }
}

// One axis's switches after the other, as often on every board.
static void poll_inputs(void)
{
    uint8_t turn = machine.turn % INPUT_TURNS;

    if (turn < CONFIG_AXES) {
        inputs_poll(turn);
        drivers_poll(turn);
    }
    seek_poll();
}

// What axis i leaves of the budget.
static uint8_t decode(uint8_t i, uint8_t budget)
{
    struct axis *axis = machine_axis(i);

    machine_follow_due(i);
    cpu_section(axis->line.smooth ? CPU_SECTION_SMOOTH : CPU_SECTION_PLAIN);
    budget =
        axis_decode(axis, &machine.period, machine.settings.backlash_policy == 0, budget);
    cpu_section(CPU_SECTION_ROUND);
    return budget;
}

#if CONFIG_AXES == 1
static void decode_in_turn(uint8_t budget)
{
    if (!axis_decoded(machine_axis(0))) {
        (void)decode(0, budget);
    }
}
#else
#define ALL_DECODED UINT16_MAX
#define AHEAD_UNIT  256u // ticks
#define AHEAD_MAX   (UINT16_MAX - 1u)

// How far axis i is decoded ahead of its account; ALL_DECODED if it needs no more now.
static uint16_t ahead(uint8_t i)
{
    if (axis_decoded(machine_axis(i))) {
        return ALL_DECODED;
    }
    uint32_t units = axis_ahead_ticks(machine_axis(i)) / AHEAD_UNIT;

    return units < AHEAD_MAX ? (uint16_t)units : AHEAD_MAX;
}

static uint8_t nearest(const uint16_t *has)
{
    uint8_t found = 0;

    for (uint8_t i = 1; i < CONFIG_AXES; i++) {
        if (has[i] < has[found]) {
            found = i;
        }
    }
    return found;
}

// The axis nearest to starving is served first, and again while no other is nearer. What the others
// have ahead does not change meanwhile.
static void decode_in_turn(uint8_t budget)
{
    uint16_t has[CONFIG_AXES];

    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        has[i] = ahead(i);
    }
    for (uint8_t calls = DECODE_CALLS; calls != 0 && budget != 0; calls--) {
        uint8_t i = nearest(has);
        if (has[i] == ALL_DECODED) {
            return;
        }
        uint8_t once = budget < DECODE_AT_ONCE ? budget : DECODE_AT_ONCE;
        budget = (uint8_t)(budget - once + decode(i, once));
        has[i] = ahead(i);
    }
}
#endif

static void decode_some(void)
{
    // One that is held back by its token or driver may be so for long, beside others that run.
    bool starting = machine.starting != 0 && (CONFIG_AXES == 1 || start_near());

    decode_in_turn(starting ? DECODE_BUDGET_STARTING : DECODE_BUDGET);
}

void round_poll(void)
{
    cpu_section(CPU_SECTION_ROUND);
    // First: behind an underrun the place of a clock edge is not known.
    take_underruns();
    if (!seek_has_clock_input()) {
        take_capture();
    }
    follow_in_turn();
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        supervise(i);
    }
    // Where the waits of one axis add up to less than its shortest interval nothing can lag.
    if (CONFIG_AXES > 1) {
        time_check_poll();
    }
    safety_poll();
    poll_inputs();
    // With several axes its registers alone cost 50 cycles.
    if (CONFIG_AXES == 1 || machine.starting != 0) {
        start_poll();
    }
    watch_clock();
    store_poll();
    decode_some();
}
