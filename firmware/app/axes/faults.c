// SPDX-License-Identifier: MIT
#include "app/axes/faults.h"

#include "app/axes/axes.h"   // axes_get
#include "app/axes/events.h" // events_note
#include "app/axes/permit.h" // permit_set
#include "app/axes/token.h"  // token_set
#include "base/apart.h"      // APART
#include "base/require.h"    // require_failed
#include "hal/estop.h"       // estop_latched
#include "hal/step_timer.h"  // step_timer_halt

static struct fault_record first_fault;
static bool time_lost;

void faults_start(void)
{
    faults_clear();
    first_fault.mask = 0;
}

static void halt_axis(uint8_t i)
{
    struct axis *axis = axes_get(i);

    if (lifecycle_moving(&axis->life)) {
        step_timer_halt(i);
    }
    axis_fail(axis);
}

// The outputs come first, because writing the record takes time.
void faults_latch_at(enum fault code, uint8_t axis, uint16_t argument)
{
    permit_set(false);
    token_set(0);
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        halt_axis(i);
    }
    uint32_t pixel = axes_get(axis)->ledger.pixel + 1u;

    if (first_fault.code == FAULT_none) {
        first_fault.code = (uint8_t)code;
        first_fault.axis = axis;
        first_fault.argument = argument;
        first_fault.pixel = pixel;
    }
    if ((first_fault.mask >> (uint8_t)code & 1u) == 0) {
        events_note((uint16_t)code, axis, argument, pixel);
    }
    first_fault.mask |= (uint32_t)1 << (uint8_t)code;
}

APART void faults_latch_plain_at(enum fault code, uint8_t axis)
{
    faults_latch(code, axis, 0);
}

void faults_latch_underrun(uint8_t axis)
{
    struct axis *late = axes_get(axis);

    late->underruns++;
    time_lost = true;
    // The handler of the stop may be what the step interrupt waited for.
    if (estop_latched()) {
        faults_latch_plain(FAULT_estop, axis);
    }
    faults_latch(FAULT_underrun, axis, late->underruns);
    if (CONFIG_AXES > 1) {
        // The check of time may see it before the round has taken what the interrupt noted.
        (void)step_timer_take_underrun(axis);
    }
}

void faults_latch_stray(uint8_t axis)
{
    time_lost = true;
    faults_latch_plain(FAULT_stray_steps, axis);
}

void require_failed(uint16_t line)
{
    faults_latch(FAULT_internal, 0, line);
}

const struct fault_record *faults_record(void)
{
    return &first_fault;
}

bool faults_time_lost(void)
{
    return time_lost;
}

void faults_clear(void)
{
    first_fault = (struct fault_record){.code = FAULT_none};
    time_lost = false;
}
