// SPDX-License-Identifier: MIT
#include "app/watch/inputs.h"

#include "app/axes/axes.h"         // axes_get
#include "app/axes/faults.h"       // faults_latch
#include "app/settings/settings.h" // settings_now
#include "base/apart.h"            // APART
#include "hal/clock.h"             // clock_now_units
#include "hal/switches.h"          // switches_read

#define LIMITS (SWITCH_LIMIT_MINUS | SWITCH_LIMIT_PLUS)

#define SWITCHES 3u

// The switches of one axis. Bits are as in hal/switches.h, set for a closed or tripped switch.
struct look {
    uint8_t state;                  // filtered
    uint8_t seen;                   // at the last look
    uint16_t since_units[SWITCHES]; // last change of each, low 16 bits; home first
    uint16_t position;              // low 16 bits, at the last look with a limit tripped
};

static struct look switch_looks[CONFIG_AXES];

static struct look *look_of(uint8_t axis)
{
    return &switch_looks[CONFIG_INDEX(axis)];
}

void inputs_start(void)
{
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        switch_looks[i] = (struct look){0};
    }
}

bool inputs_home_inverted(void)
{
    return (settings_now()->inputs_inverted & 1u) != 0;
}

// Switches that read high when they are closed or tripped.
static uint8_t tripped_levels(void)
{
    uint8_t home = inputs_home_inverted() ? SWITCH_HOME : 0;
    uint8_t limits = (settings_now()->inputs_inverted & 2u) != 0 ? LIMITS : 0;

    return (uint8_t)(home | limits);
}

// True when the time since since_units is longer than the filter time.
static APART bool has_lasted(uint16_t now_units, uint16_t since_units)
{
    return (uint16_t)(now_units - since_units) >
           clock_units_of_us(settings_now()->input_filter_us);
}

APART bool inputs_lasted(uint16_t since_units)
{
    return has_lasted((uint16_t)clock_now_units(), since_units);
}

// Filter each switch by itself, since a chattering switch must not hide another one. Returns the
// switches whose filtered state has just changed.
static uint8_t filter_switches(struct look *inputs, uint8_t now)
{
    uint16_t now_units = (uint16_t)clock_now_units();
    uint8_t moved = now ^ inputs->seen;
    uint8_t wrong = now ^ inputs->state;
    uint8_t changed = 0;
    uint16_t *since = inputs->since_units;

    for (uint8_t bit = 1; bit < SWITCH_ALL; bit = (uint8_t)(bit << 1)) {
        if ((moved & bit) != 0) {
            *since = now_units;
        } else if ((wrong & bit) != 0 && has_lasted(now_units, *since)) {
            changed |= bit;
        }
        since++;
    }
    inputs->seen = now;
    inputs->state ^= changed;
    return changed;
}

// The limits of an axis that its home switch is, too.
static uint8_t shared_limits(uint8_t axis)
{
    uint8_t bits = (uint8_t)settings_now()->home_is_limit;

    if (!FEATURE_SHARED_SWITCH) {
        return 0;
    }
    if (CONFIG_AXES > 1) {
        bits = (uint8_t)(bits >> (uint8_t)(2u * axis));
    }
    return (uint8_t)(bits << 1) & LIMITS;
}

// Tripped limits, by pins of their own and by a home switch that is one of them.
static uint8_t tripped_limits(uint8_t axis)
{
    uint8_t state = look_of(axis)->state;

    if (FEATURE_SHARED_SWITCH && (state & SWITCH_HOME) != 0) {
        state |= shared_limits(axis);
    }
    return state & LIMITS;
}

// Latch a fault when an axis moves on towards one of these limits. The axis may stand there or move
// away. The position is noted at rest too, because a last step may follow a stop and homing changes
// the position; and while a limit waits, which is not among these then.
static void watch_limits(uint8_t i, uint8_t limits, bool first_look)
{
    struct axis *axis = axes_get(i);
    struct look *inputs = look_of(i);

    (void)axes_advance(i, LEDGER_EXACTLY);
    uint16_t position = (uint16_t)ledger_position(&axis->ledger);
    int16_t moved = (int16_t)(position - inputs->position);

    inputs->position = position;
    if (first_look || axis->life.state != AXIS_RUNNING) {
        return;
    }
    if (moved > 0 && (limits & SWITCH_LIMIT_PLUS) != 0) {
        faults_latch_plain(FAULT_limit_plus, i);
    } else if (moved < 0 && (limits & SWITCH_LIMIT_MINUS) != 0) {
        faults_latch_plain(FAULT_limit_minus, i);
    }
}

void inputs_poll(uint8_t axis, bool home_is_sought)
{
    struct look *inputs = look_of(axis);
    uint8_t now = (uint8_t)((switches_read(axis) ^ tripped_levels()) ^ SWITCH_ALL);
    bool changed = filter_switches(inputs, now) != 0;
    uint8_t limits = tripped_limits(axis);

    if (limits != 0) {
        if (home_is_sought) {
            limits &= (uint8_t)~shared_limits(axis);
        }
        watch_limits(axis, limits, changed);
    }
}

bool inputs_home_closed(uint8_t axis)
{
    return (look_of(axis)->state & SWITCH_HOME) != 0;
}

bool inputs_settled(uint8_t axis)
{
    const struct look *inputs = look_of(axis);

    return ((inputs->seen ^ inputs->state) & SWITCH_HOME) == 0 &&
           inputs_lasted(inputs->since_units[0]);
}

uint16_t inputs_all(void)
{
    uint16_t all = 0;

    for (uint8_t i = CONFIG_AXES; i-- != 0;) {
        all = (uint16_t)(all << 4 | look_of(i)->state);
    }
    return all;
}
