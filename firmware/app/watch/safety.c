// SPDX-License-Identifier: MIT
#include "app/watch/safety.h"

#include "app/axes/axes.h"         // axes_first_moving
#include "app/axes/events.h"       // events_note
#include "app/axes/faults.h"       // faults_latch
#include "app/bus/traffic.h"       // traffic_last_request_ms
#include "app/settings/settings.h" // settings_now
#include "base/apart.h"            // APART
#include "hal/clock.h"             // clock_now_ms
#include "hal/cpu.h"               // cpu_*
#include "hal/estop.h"             // estop_*
#include "hal/step_timer.h"        // step_timer_heartbeat

#define RESET_POWER_ON   0x01u // bits of the reset cause
#define RESET_UNEXPECTED 0x0Cu // brown-out, watchdog
#define ESTOP_INVERTED   0x04u // bit of setting inputs_inverted

static uint8_t heartbeats[CONFIG_AXES]; // of each step interrupt, at its last check
static uint8_t axes_alive; // axes with a new heartbeat since the watchdog was fed
static uint8_t looked_at;  // the axis to check next

static APART bool estop_inverted(void)
{
    return (settings_now()->inputs_inverted & ESTOP_INVERTED) != 0;
}

void safety_start(void)
{
    uint8_t cause = cpu_reset_cause();

    axes_alive = 0;
    events_note(EVENT_RESET + cause, 0, 0, 0);
    estop_start(estop_inverted());
    // A supply that comes up slowly sets the brown-out bit too, beside the power-on bit: no fault.
    if ((cause & RESET_POWER_ON) == 0 && (cause & RESET_UNEXPECTED) != 0) {
        faults_latch(FAULT_reset, 0, cause);
    }
    cpu_watchdog_start();
}

static bool needs_no_heartbeat(uint8_t i)
{
    enum step_engine_state state = step_timer_state(i);

    return state == STEP_ENGINE_HALTED ||
           (CONFIG_AXES > 1 && state == STEP_ENGINE_PARKED);
}

// Feed the watchdog when every axis is alive; one axis is checked in each round. A halted or a
// parked axis counts as alive even without a new heartbeat. An axis whose interrupt does not
// come at all keeps
// the watchdog from being fed: its timer repeats the last period, STEP edge included, and only a
// reset ends that.
static void feed_watchdog(void)
{
    uint8_t i = CONFIG_INDEX(looked_at);
    uint8_t heartbeat = step_timer_heartbeat(i);

    if (CONFIG_AXES > 1) {
        looked_at = CONFIG_INDEX((i + 1u) % CONFIG_AXES);
    }
    if (heartbeat == heartbeats[CONFIG_INDEX(i)] && !needs_no_heartbeat(i)) {
        return;
    }
    heartbeats[CONFIG_INDEX(i)] = heartbeat;
    if (CONFIG_AXES > 1) {
        axes_alive = (uint8_t)(axes_alive | axis_bit(i));
    }
    if (CONFIG_AXES == 1 || axes_alive == ALL_AXES) {
        axes_alive = 0;
        cpu_watchdog_feed();
    }
}

static bool bus_silent(void)
{
    uint16_t limit_ms = settings_now()->bus_timeout_ms;

    return limit_ms != 0 &&
           (uint16_t)(clock_now_ms() - traffic_last_request_ms()) > limit_ms;
}

// Latch a fault of the first axis that moves, or of axis 0, in the pixel that it has reached.
static void latch_for_moving(enum fault code)
{
    uint8_t axis = (uint8_t)(axes_first_moving() % CONFIG_AXES);

    (void)axes_advance(axis, LEDGER_EXACTLY);
    faults_latch_plain(code, axis);
}

static void latch_bus_silence(void)
{
    uint8_t moving = axes_first_moving();

    if (moving != NO_AXIS) {
        faults_latch(FAULT_bus_silent, moving, settings_now()->bus_timeout_ms);
    }
}

void safety_poll(void)
{
    feed_watchdog();
    estop_poll(estop_inverted());
    if (estop_latched()) {
        latch_for_moving(FAULT_estop);
    }
    if (!cpu_stack_intact()) {
        latch_for_moving(FAULT_stack_overflow);
    }
    if (bus_silent()) {
        latch_bus_silence();
    }
}

bool safety_allows(void)
{
    return !estop_tripped() && cpu_stack_intact();
}
