// SPDX-License-Identifier: MIT
#include "app/start.h"

#include "app/drivers.h"    // drivers_settling
#include "app/machine.h"    // machine
#include "app/witness.h"    // witness_excuse
#include "hal/step_timer.h" // step_timer_release

// Room that line zero leaves the main loop to come by and release the line: a reply being built
// takes a good two milliseconds.
#define START_MIN_TICKS ((int32_t)60000)
// Release as soon as the delay fits, with a margin.
#define RELEASE_MAX_TICKS ((int32_t)120000)
// The delay is two periods; the second covers the direction set-up time, and neither may be too
// short for the commands before it.
#define COMMANDS_TICKS ((int32_t)1000)

static int32_t release_min_ticks(void)
{
    int32_t setup_ticks =
        (int32_t)machine.settings.dir_setup_us * (int32_t)(CONFIG_TIMER_HZ / 1000000uL);

    return 2 * (setup_ticks + COMMANDS_TICKS);
}

// Ticks from the newest loaded period to the first period of the line.
static int32_t ticks_to_start(const struct axis *axis, uint32_t zero_ticks)
{
    return (int32_t)(zero_ticks - STEP_TIMER_EDGE_TICKS + axis->feed.lead_in_ticks -
                     axis->ledger.loaded_ticks);
}

static bool waits(uint8_t i)
{
    uint8_t bit = axis_bit(i);

    return machine_axis(i)->state == AXIS_ARMED && (machine.clocked & bit) != 0 &&
           (machine.starting & bit) == 0;
}

// The same zero for every waiting axis, or they would not run in step.
static uint32_t common_zero(uint32_t edge_ticks)
{
    uint32_t zero = edge_ticks + machine.period.whole_ticks;

    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        while (waits(i) && ticks_to_start(machine_axis(i), zero) < START_MIN_TICKS) {
            zero += machine.period.whole_ticks;
        }
    }
    return zero;
}

// Armed, but `go` is still to come, or a driver needs its time.
static bool held_back(void)
{
    return machine.token != 0 || drivers_settling();
}

// Decoded as far ahead as memory allows. An edge before that is let pass: the slow first steps of
// a line cost the most decoding, and time ahead of them is only to be had at rest.
static bool all_ready(void)
{
    if (held_back()) {
        return false;
    }
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        if (waits(i) && !axis_decoded(machine_axis(i))) {
            return false;
        }
    }
    return true;
}

bool start_clocked_axis_runs(void)
{
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        if (machine_axis(i)->state == AXIS_RUNNING &&
            (machine.clocked & axis_bit(i)) != 0) {
            return true;
        }
    }
    return false;
}

void start_on_edge(uint32_t edge_ticks)
{
    if (!all_ready()) {
        return;
    }
    uint32_t zero = common_zero(edge_ticks);
    bool any = false;

    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        if (waits(i)) {
            machine_axis(i)->zero_ticks = zero;
            machine.starting = (uint8_t)(machine.starting | axis_bit(i));
            any = true;
        }
    }
    // One line is the clock's reference; a later start does not take that away from it.
    if (any && (CONFIG_AXES == 1 || !start_clocked_axis_runs())) {
        clock_watch_follow(&machine.watch, &machine.period, zero);
    }
}

void start_now(uint8_t axis)
{
    machine.starting = (uint8_t)(machine.starting | axis_bit(axis));
}

// The line's first interval can be merged into the delay only as long as that is not released.
static bool begun(const struct axis *axis)
{
    return !axis->in_line || !axis->feed.merge;
}

// Those that wait for the clock have their place in time already.
static bool may_release(uint8_t i)
{
    uint8_t bit = axis_bit(i);

    return (machine.starting & bit) != 0 &&
           ((machine.clocked & bit) != 0 || !held_back());
}

#if CONFIG_AXES > 1
bool start_near(void)
{
    bool near = false;

    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        near = near || may_release(i);
    }
    return near;
}
#endif

// False when an idle period began meanwhile: the next attempt has a whole one.
static bool release(uint8_t i)
{
    struct axis *axis = machine_axis(i);

    if (!machine_follow(i) || !begun(axis)) {
        return true;
    }
    if ((machine.clocked & axis_bit(i)) == 0) {
        axis->zero_ticks = axis->ledger.loaded_ticks + STEP_TIMER_EDGE_TICKS -
                           axis->feed.lead_in_ticks + 2u * (uint32_t)START_MIN_TICKS;
    }
    int32_t delay = ticks_to_start(axis, axis->zero_ticks);

    if (delay > RELEASE_MAX_TICKS) {
        return true;
    }
    if (delay < release_min_ticks()) {
        machine_fault(FAULT_start_late, i, 0);
        return true;
    }
    if (!step_timer_release(i, &axis->feed, (uint32_t)delay, axis->ledger.idle_seen)) {
        return false;
    }
    if (axis->state != AXIS_ARMED) {
        // A promise was broken on the way: a fault, and nothing may run.
        step_timer_halt(i);
        return true;
    }
    machine.starting = (uint8_t)(machine.starting & ~axis_bit(i));
    axis->state = AXIS_RUNNING;
    witness_excuse(i);
    return true;
}

void start_poll(void)
{
    uint8_t i = 0;

    // At once again: rounds as long as an idle period would meet its end every time.
    while (machine.starting != 0 && i < CONFIG_AXES) {
        if (!may_release(i) || release(i)) {
            i++;
        }
    }
}
