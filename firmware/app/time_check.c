// SPDX-License-Identifier: MIT
#include "app/time_check.h"

#include "app/axes.h"       // axes_*
#include "app/faults.h"     // faults_latch_underrun
#include "hal/clock.h"      // clock_now_units
#include "hal/step_timer.h" // step_timer_start

// Time between two checks. A check inside a pulse train divides and costs up to 1500 cycles.
#define CHECK_EVERY_UNITS 1024u

static uint32_t started_units;
static uint16_t
    checked_units; // last check, a multiple of CHECK_EVERY_UNITS that tells whose turn it is

void time_check_start(void)
{
    step_timer_start();
    // A board with a single axis makes no checks.
    if (CONFIG_AXES > 1) {
        started_units = clock_now_units();
    }
}

//     period     | running        | newest loaded  |
//     now        ^ in here        ^ never from here on: its interrupt would have loaded another
bool time_check_lags(uint8_t i)
{
    struct axis *axis = axes_get(i);
    struct engine_sample sample;
    // The time is rounded down, so that it is never ahead of the instant of the sample.
    uint32_t now_ticks = (clock_now_units() - started_units - 1u) * CLOCK_UNIT_TICKS;

    if (!axes_sample(i, &sample)) {
        return false;
    }
    uint32_t running_end =
        ledger_newest_start(&axis->ledger, &axis->feed.stream, sample.tail);
    if ((int32_t)(now_ticks - running_end) <= 0) {
        return false;
    }
    (void)axes_advance(i, LEDGER_EXACTLY);
    return true;
}

void time_check_poll(void)
{
    if ((uint16_t)((uint16_t)clock_now_units() - checked_units) < CHECK_EVERY_UNITS) {
        return;
    }
    checked_units = (uint16_t)(checked_units + CHECK_EVERY_UNITS);
    uint8_t i = (uint8_t)(checked_units / CHECK_EVERY_UNITS) % CONFIG_AXES;

    if (axes_get(i)->life.state == AXIS_RUNNING && time_check_lags(i)) {
        faults_latch_underrun(i);
    }
}
