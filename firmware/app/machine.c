// SPDX-License-Identifier: MIT
#include "app/machine.h"

#include "app/store.h"       // store_load
#include "base/require.h"    // require_failed
#include "hal/clock.h"       // clock_now_units
#include "hal/cpu.h"         // cpu_section
#include "hal/estop.h"       // permit_write
#include "hal/pixel_clock.h" // pixel_clock_take
#include "hal/step_timer.h"  // step_timer_*
#include "hal/switches.h"    // switch_capture_*

#define TICKS_PER_US ((uint32_t)(CONFIG_TIMER_HZ / 1000000uL))
// All axes cross a pixel edge at the same time. Beginning a run costs their step interrupts more
// than going on with one: let them do so some steps apart.
#define RUN_STAGGER_STEPS 2u

struct machine machine;

void machine_init(void)
{
    store_load();
    machine.seek.axis = SEEK_NOBODY;
    switch_capture_stop();
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

    (void)pixel_period_set(&machine.period,
                           CONFIG_TIMER_HZ,
                           settings_u32(settings->pixel_hz_num),
                           settings_u32(settings->pixel_hz_den));
    // A line that is over is the clock's reference no longer: its period may be another now.
    clock_watch_rest(&machine.watch);
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
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        machine_axis(i)->feed.turn_ticks = machine.limits.reversal_min_ticks / 2u;
    }
}

uint8_t machine_moving_axis(void)
{
    uint8_t i = 0;

    while (i < CONFIG_AXES && machine_axis(i)->state != AXIS_ARMED &&
           machine_axis(i)->state != AXIS_RUNNING) {
        i++;
    }
    return i;
}

bool machine_queued(void)
{
    bool queued = machine_moving_axis() != CONFIG_AXES;

    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        queued = queued || run_queue_fill(&machine_axis(i)->queue) != 0;
    }
    return queued;
}

// 1.5 pixel periods and up to 28 us. Whole bytes and a small factor: every round asks.
uint32_t machine_clock_patience_units(void)
{
    return machine.period.whole_ticks / 256u * 6u + 7u;
}

void machine_edge_dropped(void)
{
    machine.edge_seen_units = clock_now_units();
    clock_watch_forget(&machine.watch);
}

static void halt_axis(uint8_t i)
{
    if (machine_axis(i)->state == AXIS_ARMED || machine_axis(i)->state == AXIS_RUNNING) {
        step_timer_halt(i);
        machine_axis(i)->in_line = false;
        machine_axis(i)->state = AXIS_FAULT;
    }
    machine.starting &= (uint8_t)~axis_bit(i);
    machine.clocked &= (uint8_t)~axis_bit(i);
}

void machine_permit(bool on)
{
    machine.permit = on;
    permit_write(on);
}

// First the outputs: the record takes its time.
void machine_fault(enum fault code, uint8_t axis, uint16_t argument)
{
    struct fault_record *fault = &machine.fault;

    machine_permit(false);
    machine.token = 0;
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        halt_axis(i);
    }
    if (fault->code == FAULT_none) {
        fault->code = (uint8_t)code;
        fault->axis = axis;
        fault->argument = argument;
        fault->pixel = machine_axis(axis)->ledger.pixel + 1u;
    }
    if ((fault->mask >> (uint8_t)code & 1u) == 0) {
        events_note(
            (uint16_t)code, axis, argument, machine_axis(axis)->ledger.pixel + 1u);
    }
    fault->mask |= (uint32_t)1 << (uint8_t)code;
}

void require_failed(uint16_t line)
{
    machine_fault(FAULT_internal, 0, line);
}

void machine_account(uint8_t axis)
{
    struct axis *rested = machine_axis(axis);

    struct engine_sample sample = step_timer_sample(axis);

    ledger_follow(&rested->ledger, &rested->feed, &sample);
}

static bool any_armed(void)
{
    uint8_t i = 0;

    while (i < CONFIG_AXES && machine_axis(i)->state != AXIS_ARMED) {
        i++;
    }
    return i < CONFIG_AXES;
}

void machine_discard(uint8_t i)
{
    struct axis *axis = machine_axis(i);
    uint8_t bit = axis_bit(i);
    uint8_t slot = 0;

    machine.starting &= (uint8_t)~bit;
    machine.clocked &= (uint8_t)~bit;
    axis->in_line = false;
    axis->state = AXIS_EMPTY;
    if (CONFIG_AXES == 1 || !any_armed()) {
        machine.token = 0;
    }
    if (!step_engine_going(step_timer_state(i))) {
        machine_account(i);
        if (step_timer_settle(i, &slot)) {
            machine.stopping &= (uint8_t)~bit;
            axis_discard(axis, slot);
            return;
        }
    }
    machine.stopping |= bit;
    step_timer_halt(i);
}

void machine_underrun(uint8_t axis)
{
    machine_axis(axis)->underruns++;
    machine.time_lost = true;
    machine_fault(FAULT_underrun, axis, machine_axis(axis)->underruns);
}

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

void machine_follow_due(uint8_t axis)
{
    (void)follow(axis, false);
}

bool machine_follow(uint8_t axis)
{
    return follow(axis, true);
}
