// SPDX-License-Identifier: MIT
#include "app/registers/commands.h"

#include <stddef.h> // NULL

#include "app/axes/axes.h"          // axes_*
#include "app/axes/faults.h"        // faults_*
#include "app/axes/limits.h"        // limits_*
#include "app/axes/mark.h"          // mark_set
#include "app/axes/permit.h"        // permit_set
#include "app/axes/reference.h"     // reference_*
#include "app/axes/token.h"         // token_*
#include "app/motion/clock_edges.h" // clock_edges_*
#include "app/motion/seek.h"        // seek_*
#include "app/motion/start.h"       // start_now
#include "app/settings/settings.h"  // settings_*
#include "app/settings/store.h"     // store_*
#include "app/watch/drivers.h"      // drivers_write
#include "app/watch/safety.h"       // safety_allows
#include "app/watch/time_check.h"   // time_check_start
#include "base/flash.h"             // IN_FLASH
#include "hal/estop.h"              // estop_release
#include "hal/pixel_clock.h"        // pixel_clock_drop
#include "hal/step_timer.h"         // step_timer_*
#include "line/line_speeds.h"       // line_speeds_fit

static struct order last_order;

// A command for axes is checked and executed for each axis of the order; a command for the board is
// checked and executed once, with axis 0.
typedef bool (*command_test)(uint8_t axis, const struct order *order);
typedef void (*command_action)(uint8_t axis, const struct order *order);

static uint8_t state_of(uint8_t i)
{
    return axes_get(i)->life.state;
}

static bool always_possible(uint8_t axis, const struct order *order)
{
    (void)axis;
    (void)order;
    return true;
}

// Only one token at a time: another token would start, or hold back, the axes that are armed
// already. Nobody joins those that wait for the edge that `go` has named: it may be near.
static bool token_fits(const struct order *order)
{
    // Nor is a burst's line zero forgotten that lines need whose axes are about to be armed.
    if (token_edge_by_gate() && start_clocked_axis_runs()) {
        return false;
    }
    return !FEATURE_TOKENS || CONFIG_AXES == 1 || !axes_any_armed() ||
           (token_is(order->argument) && !token_edge_named());
}

#if FEATURE_HOMING || CONFIG_AXES > 1
static bool names_axis(const struct order *order, uint8_t i)
{
    return ((uint8_t)order->mask & axis_bit(i)) != 0;
}
#endif

#if FEATURE_HOMING
static bool front_is_seek(uint8_t i)
{
    bool opening = false;

    return axis_seeks(axes_get(i), &opening);
}

// Only one switch is watched at a time. A seek must be in memory as a whole, because otherwise it
// could not slow down at once.
static bool seek_fits(uint8_t i, const struct order *order)
{
    if (!front_is_seek(i)) {
        return true;
    }
    for (uint8_t other = 0; CONFIG_AXES > 1 && other < i; other++) {
        if (names_axis(order, other) && front_is_seek(other)) {
            return false;
        }
    }
    return seek_now()->axis == NO_AXIS && axes_get(i)->whole_lines != 0;
}
#else
static bool seek_fits(uint8_t i, const struct order *order)
{
    (void)i;
    (void)order;
    return true;
}
#endif

#if CONFIG_AXES > 1
// True when this axis moves, or is armed, once the order is carried out.
static bool would_move(uint8_t i, const struct order *order)
{
    return names_axis(order, i) || lifecycle_moving(&axes_get(i)->life);
}

// The first axis whose lines are too fast for the axes that would move together; NO_AXIS if none.
static uint8_t first_too_fast(const struct order *order)
{
    uint8_t together = 0;
    uint8_t found = 0;

    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        together = (uint8_t)(together + (would_move(i, order) ? 1u : 0u));
    }
    const struct line_limits *limits = limits_together(together);

    while (found < CONFIG_AXES && (!would_move(found, order) ||
                                   line_speeds_fit(&axes_get(found)->check, limits))) {
        found++;
    }
    return found;
}

// Say which axis is too fast, where the host looks for the reason.
static void tell_too_fast(const struct order *order)
{
    uint8_t i = order->command == COMMAND_ARM ? first_too_fast(order) : NO_AXIS;

    if (i != NO_AXIS) {
        axes_get(i)->line_error = LINE_too_fast_together;
        axes_get(i)->line_error_pixel = 0;
    }
}
#else
static uint8_t first_too_fast(const struct order *order)
{
    (void)order;
    return NO_AXIS;
}

static void tell_too_fast(const struct order *order)
{
    (void)order;
}
#endif

// The axis's front line can be armed, by the host or by the board.
static bool can_arm_line(uint8_t i, const struct order *order)
{
    return state_of(i) == AXIS_LOADED && !faults_any() && seek_fits(i, order) &&
           clock_edges_allow(axes_get(i)) && first_too_fast(order) == NO_AXIS;
}

static bool can_arm(uint8_t i, const struct order *order)
{
    return can_arm_line(i, order) && token_fits(order);
}

static void arm_line(uint8_t i)
{
    struct axis *axis = axes_get(i);

    drivers_write(i, true);
#if FEATURE_HOMING
    bool opening = false;
    if (axis_seeks(axis, &opening)) {
        seek_begin(i, opening);
    }
#endif
    // Call this before the axis itself counts as one that needs the clock.
    if (axis_waits_for_edge(axis) && settings_now()->sync != SYNC_FREE) {
        clock_edges_await();
    }
    if (axis_arm(axis, reference_pixel()) && !axis->clocked) {
        start_now(i);
    }
}

static void arm_axis(uint8_t i, const struct order *order)
{
    token_set(order->argument);
    arm_line(i);
}

#if FEATURE_GATE
void commands_arm_next(uint8_t axis)
{
    const struct order order = {.mask = axis_bit(axis), .command = COMMAND_ARM};

    if (can_arm_line(axis, &order)) {
        arm_line(axis);
    }
}
#endif

#if FEATURE_TOKENS
// Possible while some axis waits for a token, with an edge (any, for lines that do not wait for the
// clock). A wrong token is possible too, and is a fault.
static bool can_go(uint8_t axis, const struct order *order)
{
    (void)axis;
    return order->edge != 0 && token_held() && axes_first_moving() != NO_AXIS;
}

static void take_go(uint8_t axis, const struct order *order)
{
    (void)axis;
    if (!token_is(order->argument)) {
        faults_latch(FAULT_wrong_token, axes_first_moving(), order->argument);
        return;
    }
    start_go(order->edge);
}

static void take_mark(uint8_t axis, const struct order *order)
{
    (void)axis;
    (void)order;
    mark_set();
}
#endif

static bool does_not_run(uint8_t i, const struct order *order)
{
    (void)order;
    return state_of(i) != AXIS_RUNNING && state_of(i) != AXIS_FAULT;
}

static void discard_axis(uint8_t i, const struct order *order)
{
    (void)order;
    axes_stop(i);
}

// Stopping an axis also drops PERMIT, so that a laser cannot burn in one place.
static void stop_axis(uint8_t i, const struct order *order)
{
    (void)order;
    permit_set(false);
    if (state_of(i) != AXIS_FAULT) {
        axes_stop(i);
    }
}

// True when the axis makes no steps: it does not run, is not armed, which would let it start by
// itself, and is not stopping, since a last step may then be still to come.
static bool is_still(uint8_t i, const struct order *order)
{
    return does_not_run(i, order) && !lifecycle_armed(&axes_get(i)->life) &&
           state_of(i) != AXIS_STOPPING;
}

#if FEATURE_HOMING
static bool can_zero(uint8_t i, const struct order *order)
{
    return is_still(i, order) && seek_can_zero(i);
}

static void zero_axis(uint8_t i, const struct order *order)
{
    (void)order;
    seek_zero(i);
}
#endif

static void enable_driver(uint8_t i, const struct order *order)
{
    (void)order;
    drivers_write(i, true);
}

static void disable_driver(uint8_t i, const struct order *order)
{
    (void)order;
    drivers_write(i, false);
}

// Start timers and ledgers anew, so that they agree again. Positions are kept.
static void restart_time(void)
{
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        axes_advance_rested(i);
    }
    time_check_start();
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        struct axis *axis = axes_get(i);
        axis_stop(axis);
        ledger_restart(&axis->ledger, STEP_IDLE_TICKS);
        axis_discard(axis, 0);
    }
    // A clock edge that waits was captured in the old time.
    (void)pixel_clock_drop();
    reference_rest();
}

// Make an axis usable again. The emergency stop has halted every engine, also those of axes that
// only have queued lines; such axes keep their lines.
static void revive_axis(uint8_t i)
{
    uint8_t slot = 0;

    if (state_of(i) == AXIS_FAULT) {
        axes_stop(i);
    } else if (state_of(i) != AXIS_STOPPING) {
        (void)step_timer_settle(i, &slot);
    }
}

static bool can_clear(uint8_t axis, const struct order *order)
{
    (void)axis;
    (void)order;
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        if (step_engine_going(step_timer_state(i))) {
            return false;
        }
    }
    // An emergency stop may be latched before the main loop has seen it.
    return !faults_any() || safety_allows();
}

static void clear_fault(uint8_t axis, const struct order *order)
{
    (void)axis;
    (void)order;
    if (!faults_any()) {
        return;
    }
    // This comes first: an emergency stop from here on is latched anew, and its fault follows.
    estop_release();
    if (faults_time_lost()) {
        restart_time();
    }
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        revive_axis(i);
    }
    faults_clear();
}

// For commands that replace or store the settings: they need the key, and no line may be queued,
// because lines are checked against the settings at the time of their upload.
static bool has_key(uint8_t axis, const struct order *order)
{
    (void)axis;
    return order->argument == COMMANDS_KEY && !axes_any_queued() && !store_busy();
}

#if FEATURE_STORE
static void store_settings(uint8_t axis, const struct order *order)
{
    (void)axis;
    (void)order;
    store_begin();
}
#endif

static void set_defaults(uint8_t axis, const struct order *order)
{
    (void)axis;
    (void)order;
    settings_set_defaults();
    store_note_change();
    limits_apply_settings();
}

static bool can_permit(uint8_t axis, const struct order *order)
{
    (void)axis;
    (void)order;
    return !faults_any() && !estop_latched();
}

static void set_permit(uint8_t axis, const struct order *order)
{
    (void)axis;
    permit_set(order->command == COMMAND_PERMIT_ON);
}

static void do_nothing(uint8_t axis, const struct order *order)
{
    (void)axis;
    (void)order;
}

struct command_row {
    command_test possible; // NULL: this image was built without the command
    command_action act;
    bool for_axes;
};

static const struct command_row command_table[] IN_FLASH = {
    [COMMAND_NONE] = {always_possible, do_nothing, false},
    [COMMAND_ARM] = {can_arm, arm_axis, true},
    [COMMAND_DISARM] = {does_not_run, discard_axis, true},
    [COMMAND_STOP] = {always_possible, stop_axis, true},
    [COMMAND_CLEAR_FAULT] = {can_clear, clear_fault, false},
    [COMMAND_DISCARD] = {does_not_run, discard_axis, true},
    [COMMAND_ENABLE] = {always_possible, enable_driver, true},
    [COMMAND_DISABLE] = {is_still, disable_driver, true},
#if FEATURE_HOMING
    [COMMAND_ZERO] = {can_zero, zero_axis, true},
#endif
    [COMMAND_PERMIT_ON] = {can_permit, set_permit, false},
    [COMMAND_PERMIT_OFF] = {always_possible, set_permit, false},
#if FEATURE_STORE
    [COMMAND_STORE] = {has_key, store_settings, false},
#endif
    [COMMAND_DEFAULTS] = {has_key, set_defaults, false},
#if FEATURE_TOKENS
    [COMMAND_GO] = {can_go, take_go, false},
    [COMMAND_MARK] = {always_possible, take_mark, false},
#endif
};

// True when the order names axes that exist. Disarm and stop may also name others: a broadcast
// sends them to all boards, whatever axes each board has.
static bool names_axes(const struct order *order)
{
    uint8_t command = (uint8_t)order->command;
    bool others = command == COMMAND_DISARM || command == COMMAND_STOP;
    uint8_t mask = (uint8_t)order->mask;

    if ((mask & ALL_AXES) == 0) {
        return false;
    }
    return others || (mask & (uint8_t)~ALL_AXES) == 0;
}

// Check the command, or execute it if `act` is set, for each axis of the order; a command for the
// board has only axis 0. Returns false when the order is not possible for one of the axes.
static bool each_axis(const struct order *order, bool act)
{
    struct command_row row;
    uint8_t mask = 1;

    flash_copy(&row, &command_table[(uint8_t)order->command], sizeof row);
    if (row.for_axes) {
        mask = (uint8_t)order->mask;
        if (!names_axes(order)) {
            return false;
        }
    }
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        if ((mask & axis_bit(i)) == 0) {
            continue;
        }
        if (act) {
            row.act(i, order);
        } else if (row.possible == NULL || !row.possible(i, order)) {
            return false;
        }
    }
    return true;
}

bool commands_possible(const struct order *order)
{
    return each_axis(order, false);
}

void commands_act(const struct order *order)
{
    (void)each_axis(order, true);
}

const struct order *commands_last(void)
{
    return &last_order;
}

bool commands_give(const struct order *order)
{
    if (!commands_possible(order)) {
        tell_too_fast(order);
        return false;
    }
    commands_act(order);
    last_order = *order;
    return true;
}
