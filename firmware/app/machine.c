// SPDX-License-Identifier: MIT
#include "app/machine.h"

#include "app/start.h"       // start_on_edge, start_poll
#include "app/time_check.h"  // time_check_poll
#include "base/require.h"    // require_failed
#include "hal/clock.h"       // clock_now_4us
#include "hal/cpu.h"         // cpu_section
#include "hal/pixel_clock.h" // pixel_clock_take
#include "hal/step_timer.h"  // step_timer_*
#include "hal/switches.h"    // switch_capture_waiting

// Steps decoded in one round; a round must stay short beside a serial frame's silence.
#define DECODE_BUDGET  (CONFIG_AXES == 1 ? 120u : 240u)
#define DECODE_AT_ONCE 120u
#define DECODE_CALLS   (CONFIG_AXES == 1 ? 1u : 3u)
// While an axis waits for its release, a moment of a few milliseconds that must not be missed.
#define DECODE_BUDGET_STARTING 12u
#define TICKS_PER_US           ((uint32_t)(CONFIG_TIMER_HZ / 1000000uL))
// All axes cross a pixel edge at the same time. Beginning a run costs their step interrupts more
// than going on with one: let them do so some steps apart.
#define RUN_STAGGER_STEPS 2u

struct machine machine;

// Rounds in which every axis's switches are looked at once; an axis that seeks, in every round.
#define INPUT_TURNS 4u

static uint8_t axis_bit(uint8_t axis)
{
    return (uint8_t)(1u << axis);
}

void machine_init(void)
{
    settings_defaults(&machine.settings);
    seek_init();
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        axis_init(machine_axis(i),
                  step_timer_ring(i),
                  machine.slots[i],
                  CONFIG_QUEUE_ENTRIES,
                  STEP_IDLE_TICKS);
        machine_axis(i)->feed.carried = step_timer_runs(i);
        machine_axis(i)->stagger = (uint8_t)(RUN_STAGGER_STEPS * i);
    }
    machine_apply_settings();
}

void machine_apply_settings(void)
{
    const struct settings *settings = &machine.settings;
    uint16_t turn_us = settings->dir_setup_us > settings->dir_hold_us
                           ? settings->dir_setup_us
                           : settings->dir_hold_us;

    (void)pixel_period_set(
        &machine.period, CONFIG_TIMER_HZ, settings->pixel_hz_num, settings->pixel_hz_den);
    machine.limits = (struct line_limits){
        .pixel_ticks = machine.period.whole_ticks,
        .min_interval_ticks = CONFIG_MIN_INTERVAL_TICKS,
        .smooth_min_interval_ticks = CONFIG_SMOOTH_MIN_INTERVAL_TICKS,
        .seek_min_interval_ticks = CONFIG_SEEK_MIN_INTERVAL_TICKS,
        // The direction changes in the middle of the interval.
        .reversal_min_ticks =
            (uint16_t)(2u * (turn_us * TICKS_PER_US + CONFIG_TURN_MARGIN_TICKS)),
        .max_acceleration = settings->max_acceleration,
        .start_stop_steps = settings->start_stop_steps,
    };
}

bool machine_moving(void)
{
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        if (machine_axis(i)->state == AXIS_ARMED ||
            machine_axis(i)->state == AXIS_RUNNING) {
            return true;
        }
    }
    return false;
}

bool machine_queued(void)
{
    bool queued = machine_moving();

    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        queued = queued || run_queue_fill(&machine_axis(i)->queue) != 0;
    }
    return queued;
}

// 1.5 pixel periods in units of 4 us.
static uint32_t clock_patience_4us(void)
{
    return machine.period.whole_ticks / 64u * 3u / 2u + 1u;
}

bool machine_clock_present(void)
{
    return machine.watch.edges != 0 &&
           clock_now_4us() - machine.edge_seen_4us <= clock_patience_4us();
}

static void halt_axis(uint8_t i, enum axis_state state)
{
    if (machine_axis(i)->state == AXIS_ARMED || machine_axis(i)->state == AXIS_RUNNING) {
        step_timer_empty(i);
        machine_axis(i)->in_line = false;
        machine_axis(i)->state = (uint8_t)state;
    }
    machine.starting &= (uint8_t)~axis_bit(i);
    machine.clocked &= (uint8_t)~axis_bit(i);
}

void machine_fault(enum fault code, uint8_t axis, uint16_t argument)
{
    struct fault_record *fault = &machine.fault;

    if (fault->code == FAULT_none) {
        fault->code = (uint8_t)code;
        fault->axis = axis;
        fault->argument = argument;
        fault->pixel = machine_axis(axis)->ledger.pixel + 1u;
    }
    fault->mask |= (uint16_t)(1uL << (uint8_t)code);
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        halt_axis(i, AXIS_FAULT);
    }
}

void require_failed(uint16_t line)
{
    machine_fault(FAULT_internal, 0, line);
}

static void line_finished(struct axis *axis)
{
    axis->lines_done++;
    if (axis->whole_lines != 0) {
        axis->state = AXIS_LOADED;
    } else {
        axis->state = run_queue_fill(&axis->queue) != 0 ? AXIS_LOADING : AXIS_DONE;
    }
}

void machine_account(uint8_t axis)
{
    struct axis *rested = machine_axis(axis);

    struct engine_sample sample = step_timer_sample(axis);

    ledger_follow(&rested->ledger, &rested->feed, &sample);
}

void machine_discard(uint8_t axis)
{
    machine_account(axis);
    axis_discard(machine_axis(axis), step_timer_settle(axis));
}

// A running axis that halted or came to the end of its line.
static void supervise_running(uint8_t i)
{
    struct axis *axis = machine_axis(i);

    if (step_timer_state(i) == STEP_ENGINE_HALTED) {
        machine_fault(axis->dry ? FAULT_starved : FAULT_decoder_late, i, 0);
    } else if (!axis->in_line && axis_ring_fill(axis) == 0 &&
               step_timer_state(i) == STEP_ENGINE_IDLE) {
        machine.clocked &= (uint8_t)~axis_bit(i);
        line_finished(axis);
    }
}

static void supervise(uint8_t i)
{
    if (machine_axis(i)->state == AXIS_RUNNING) {
        supervise_running(i);
    }
    if ((machine.stopping & axis_bit(i)) != 0 &&
        step_timer_state(i) != STEP_ENGINE_IN_LINE) {
        machine.stopping &= (uint8_t)~axis_bit(i);
        machine_discard(i);
    }
}

void machine_underrun(uint8_t axis)
{
    machine_axis(axis)->underruns++;
    machine.time_lost = true;
    machine_fault(FAULT_underrun, axis, machine_axis(axis)->underruns);
}

static void take_underruns(void)
{
    for (uint8_t i = 0; step_timer_underrun() && i < CONFIG_AXES; i++) {
        if (step_timer_take_underrun(i)) {
            machine_underrun(i);
        }
    }
}

// An axis's account may lag so many entries behind between its turns, one every so many rounds.
#define FOLLOW_ENTRIES 64u
#define TURN_ROUNDS    8u

// An edge was captured with a sample of this axis, which comes before any newer one.
static bool capture_waits(uint8_t i)
{
    bool clock = i == CONFIG_PIXEL_CLOCK_AXIS && pixel_clock_waiting();

    return clock || (machine.seek.axis != SEEK_NOBODY && switch_capture_waiting());
}

// False when that must wait.
static bool follow(uint8_t i, bool all)
{
    struct axis *axis = machine_axis(i);
    struct engine_sample sample = step_timer_sample(i);

    if (capture_waits(i)) {
        return false;
    }
    if (all || ledger_due(&axis->ledger, &axis->feed, &sample)) {
        cpu_section(CPU_SECTION_LEDGER);
        if (all) {
            ledger_follow(&axis->ledger, &axis->feed, &sample);
        } else {
            ledger_follow_blocks(&axis->ledger, &axis->feed, &sample);
        }
        cpu_section(CPU_SECTION_ROUND);
    }
    return true;
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
        if (i == due || (CONFIG_AXES > 1 && axis->awaits_run) ||
            behind >= FOLLOW_ENTRIES) {
            (void)follow(i, false);
        }
    }
}

bool machine_follow(uint8_t axis)
{
    return follow(axis, true);
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
        machine.edge_seen_4us = clock_now_4us();
        return;
    }
    ledger_follow(&axis->ledger, &axis->feed, &capture.sample);
    uint32_t edge_ticks = ledger_period_start(&axis->ledger, &axis->feed, capture.back) +
                          capture.ticks - PIXEL_CLOCK_CAPTURE_DELAY_TICKS;
    machine.edge_seen_4us = clock_now_4us();
    if (clock_watch_edge(&machine.watch, edge_ticks, &pixel)) {
        note_edge_error(pixel);
    }
    if (lost && machine.clocked != 0) {
        machine_fault(FAULT_clock_edge_lost, CONFIG_PIXEL_CLOCK_AXIS, 0);
        return;
    }
    start_on_edge(edge_ticks);
}

static void watch_clock(void)
{
    if (machine.clocked != 0 &&
        clock_now_4us() - machine.edge_seen_4us > clock_patience_4us()) {
        uint8_t axis = 0;
        while ((machine.clocked & axis_bit(axis)) == 0) {
            axis++;
        }
        machine_fault(FAULT_pixel_clock_missing, axis, 0);
    }
}

// One axis's switches after the other, as often on every board.
static void poll_inputs(void)
{
    uint8_t turn = machine.turn % INPUT_TURNS;

    if (turn < CONFIG_AXES) {
        inputs_poll(turn);
    }
    seek_poll();
}

// The axis nearest to starving; CONFIG_AXES when all are decoded.
static uint8_t neediest(void)
{
    uint8_t found = CONFIG_AXES;
    uint32_t least = UINT32_MAX;

    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        if (!axis_decoded(machine_axis(i))) {
            uint32_t ahead = axis_ahead_ticks(machine_axis(i));
            if (ahead < least) {
                least = ahead;
                found = i;
            }
        }
    }
    return found;
}

// What axis i leaves of the budget.
static uint8_t decode(uint8_t i, uint8_t budget)
{
    struct axis *axis = machine_axis(i);

    (void)follow(i, false);
    cpu_section(axis->line.smooth ? CPU_SECTION_SMOOTH : CPU_SECTION_PLAIN);
    budget =
        axis_decode(axis, &machine.period, machine.settings.backlash_policy == 0, budget);
    cpu_section(CPU_SECTION_ROUND);
    return budget;
}

// The axis nearest to starving is served first, and again while no other is nearer.
static void decode_neediest(void)
{
    uint8_t left = machine.starting != 0 ? DECODE_BUDGET_STARTING : DECODE_BUDGET;

    for (uint8_t calls = DECODE_CALLS; calls != 0 && left != 0; calls--) {
        uint8_t i = neediest();
        if (i == CONFIG_AXES) {
            return;
        }
        uint8_t once = left < DECODE_AT_ONCE ? left : DECODE_AT_ONCE;
        left = (uint8_t)(left - once + decode(i, once));
    }
}

void machine_poll(void)
{
    cpu_section(CPU_SECTION_ROUND);
    if (!seek_has_clock_input()) {
        take_capture();
    }
    take_underruns();
    follow_in_turn();
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        supervise(i);
    }
    // Where the waits of one axis add up to less than its shortest interval nothing can lag.
    if (CONFIG_AXES > 1) {
        time_check_poll();
    }
    poll_inputs();
    start_poll();
    watch_clock();
    decode_neediest();
}
