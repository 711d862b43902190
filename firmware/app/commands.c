// SPDX-License-Identifier: MIT
// What the host may ask of the machine, each for a mask of axes: all of them or none.
#include "app/drivers.h" // drivers_write
#include "app/machine.h"
#include "app/safety.h" // safety_allows
#include "app/start.h"  // start_now
#include "app/store.h"  // store_*
#include "app/time_check.h"
#include "base/flash.h"      // IN_FLASH
#include "hal/clock.h"       // clock_now_units
#include "hal/estop.h"       // estop_release
#include "hal/pixel_clock.h" // pixel_clock_drop
#include "hal/step_timer.h"  // step_timer_*

typedef bool (*axis_test)(const struct axis *axis);
typedef void (*axis_action)(uint8_t axis);

static bool for_axes(uint8_t mask, axis_test possible, axis_action action)
{
    if (mask == 0 || (mask >> CONFIG_AXES) != 0) {
        return false;
    }
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        if ((mask & axis_bit(i)) != 0 && !possible(machine_axis(i))) {
            return false;
        }
    }
    for (uint8_t i = 0; machine.asking == 0 && i < CONFIG_AXES; i++) {
        if ((mask & axis_bit(i)) != 0) {
            action(i);
        }
    }
    return true;
}

static bool always(const struct axis *axis)
{
    (void)axis;
    return true;
}

static bool armable(const struct axis *axis)
{
    return axis->state == AXIS_LOADED && machine.fault.code == FAULT_none;
}

// One switch is watched at a time; a seek is in memory whole, or it could not slow down at once.
static bool seeks_fit(uint8_t mask)
{
    bool opening = false;
    bool taken = machine.seek.axis != SEEK_NOBODY ||
                 (CONFIG_AXES > 1 && machine.asking == MACHINE_ASKED_SEEK);

    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        if ((mask & axis_bit(i)) != 0 && axis_seeks(machine_axis(i), &opening)) {
            if (taken || machine_axis(i)->whole_lines == 0) {
                return false;
            }
            taken = true;
            if (CONFIG_AXES > 1 && machine.asking != 0) {
                machine.asking = MACHINE_ASKED_SEEK;
            }
        }
    }
    return true;
}

static void arm(uint8_t i)
{
    struct axis *axis = machine_axis(i);
    bool clocked = axis_waits_for_edge(axis);
    bool opening = false;

    drivers_write(i, true);
    if (axis_seeks(axis, &opening)) {
        seek_begin(i, opening);
    }
    if (!axis_arm(axis, &machine.period, machine.settings.backlash_policy == 0)) {
        return;
    }
    if (clocked) {
        // Patience for the pixel clock begins now, unless edges are being seen.
        if (machine.clocked == 0 && !machine_clock_present()) {
            machine.edge_seen_units = clock_now_units();
        }
        machine.clocked = (uint8_t)(machine.clocked | axis_bit(i));
    } else {
        start_now(i);
    }
}

// One token at a time: another would start, or hold back, what is armed already.
static bool token_fits(void)
{
    bool fits = true;

    for (uint8_t i = 0; CONFIG_AXES > 1 && i < CONFIG_AXES; i++) {
        fits = fits && (machine_axis(i)->state != AXIS_ARMED ||
                        machine.order[2] == machine.token);
    }
    return fits;
}

static bool arm_all(uint8_t mask)
{
    if (!token_fits() || !seeks_fit(mask) || !for_axes(mask, armable, arm)) {
        return false;
    }
    if (machine.asking == 0) {
        machine.token = machine.order[2];
    }
    return true;
}

// With the token that the armed axes wait for they start on the next clock edge.
static bool go(void)
{
    uint16_t token = machine.order[2];
    uint8_t axis = machine_moving_axis();

    if (machine.token == 0 || axis == CONFIG_AXES) {
        return false;
    }
    if (token != machine.token) {
        machine_fault(FAULT_wrong_token, axis, token);
        return true;
    }
    machine.token = 0;
    // Patience for the pixel clock begins now.
    machine.edge_seen_units = clock_now_units();
    return true;
}

static bool resting(const struct axis *axis)
{
    return axis->state != AXIS_RUNNING && axis->state != AXIS_FAULT;
}

static uint8_t number_of(const struct axis *axis)
{
    return CONFIG_INDEX(axis - machine.axes);
}

// Stopping an axis also drops PERMIT, so that a laser cannot burn in one place.
static void stop(uint8_t i)
{
    machine_permit(false);
    if (machine_axis(i)->state != AXIS_FAULT) {
        machine_discard(i);
    }
}

// An armed axis begins by itself, and one that was stopped may have its last step before it.
static bool still(const struct axis *axis)
{
    return resting(axis) && axis->state != AXIS_ARMED &&
           (machine.stopping & axis_bit(number_of(axis))) == 0;
}

static bool zeroable(const struct axis *axis)
{
    return still(axis) && seek_can_zero(number_of(axis));
}

static void enable(uint8_t i)
{
    drivers_write(i, true);
}

static void disable(uint8_t i)
{
    drivers_write(i, false);
}

// Timers and ledgers agree again; positions are kept.
static void restart_time(void)
{
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        machine_account(i);
    }
    time_check_start();
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        axis_discard(machine_axis(i), 0);
        ledger_restart(&machine_axis(i)->ledger, STEP_IDLE_TICKS);
    }
    // A clock edge that waits is of the time before.
    (void)pixel_clock_drop();
    clock_watch_rest(&machine.watch);
    machine.time_lost = false;
}

// The emergency stop has halted every engine, those of queued lines too: these keep their lines.
static void revive(uint8_t i)
{
    uint8_t slot = 0;

    if (machine_axis(i)->state == AXIS_FAULT) {
        machine_discard(i);
    } else if ((machine.stopping & axis_bit(i)) == 0) {
        (void)step_timer_settle(i, &slot);
    }
}

static bool clear_fault(void)
{
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        if (step_engine_going(step_timer_state(i))) {
            return false;
        }
    }
    // An emergency stop may be latched that the main loop has not heard of yet.
    if (machine.fault.code == FAULT_none) {
        return true;
    }
    if (!safety_allows()) {
        return false;
    }
    if (machine.asking != 0) {
        return true;
    }
    // First: a stop that is pressed from here on is latched anew, and its fault follows.
    estop_release();
    if (machine.time_lost) {
        restart_time();
    }
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        revive(i);
    }
    machine.fault = (struct fault_record){.code = FAULT_none};
    return true;
}

// What needs its key.
static bool keyed(void)
{
    return machine.order[2] == MACHINE_KEY && !machine_queued() && !store_busy();
}

static bool store(void)
{
    if (!keyed()) {
        return false;
    }
    store_begin();
    return true;
}

static bool default_settings(void)
{
    if (!keyed()) {
        return false;
    }
    settings_defaults(&machine.settings);
    store_note_change();
    machine_apply_settings();
    return true;
}

static bool permit(bool on)
{
    if (on && (machine.fault.code != FAULT_none || estop_latched())) {
        return false;
    }
    if (machine.asking == 0) {
        machine_permit(on);
    }
    return true;
}

// Commands for axes, each for itself.
struct axis_command {
    axis_test possible;
    axis_action act;
};

static const struct axis_command axis_commands[] IN_FLASH = {
    [COMMAND_DISARM] = {resting, machine_discard},
    [COMMAND_STOP] = {always, stop},
    [COMMAND_DISCARD] = {resting, machine_discard},
    [COMMAND_ENABLE] = {always, enable},
    [COMMAND_DISABLE] = {still, disable},
    [COMMAND_ZERO] = {zeroable, seek_zero},
};

static bool command_axes(enum machine_command command, uint8_t mask)
{
    struct axis_command found;

    // Disarm and stop go to all boards at once, whatever axes each of them has.
    if (command <= COMMAND_STOP) {
        mask &= ALL_AXES;
    }
    flash_copy(&found, &axis_commands[command], sizeof found);
    return for_axes(mask, found.possible, found.act);
}

bool machine_do(enum machine_command command, uint8_t mask)
{
    switch ((uint8_t)command) {
    case COMMAND_NONE:
        return true;
    case COMMAND_ARM:
        return arm_all(mask);
    case COMMAND_CLEAR_FAULT:
        return clear_fault();
    case COMMAND_STORE:
        return store();
    case COMMAND_DEFAULTS:
        return default_settings();
    case COMMAND_PERMIT_ON:
    case COMMAND_PERMIT_OFF:
        return permit(command == COMMAND_PERMIT_ON);
    case COMMAND_GO:
        return go();
    default: // for axes, each for itself
        return command_axes(command, mask);
    }
}
