// SPDX-License-Identifier: MIT
// A fake of hal/switches.h: a suite sets the levels.
#include "hal/switches.h"

#include "fakes/board.h"
#include "fakes/board_parts.h"
#include "hal/step_timer.h" // step_timer_sample

static uint8_t levels[CONFIG_AXES];
static bool listening;
static uint8_t listened_axis;
static bool listens_for_high;
static bool waiting;
static struct switch_capture first;

void fake_switches_power_on(void)
{
    listening = false;
    waiting = false;
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        levels[i] = SWITCH_ALL;
    }
}

static void capture(void)
{
    uint32_t captured = fake_now_ticks() + SWITCH_CAPTURE_DELAY_TICKS;

    waiting = true;
    first = (struct switch_capture){
        .edge =
            {
                .ticks = (uint16_t)(captured -
                                    fake_timers_period_start(CONFIG_SWITCH_CAPTURE_AXIS)),
                .back = 1,
            },
    };
    step_timer_sample(CONFIG_SWITCH_CAPTURE_AXIS, &first.edge.sample);
    step_timer_sample(listened_axis, &first.seeker);
}

void fake_switch(uint8_t axis, uint8_t which, bool high)
{
    bool was_high = (levels[axis] & which) != 0;

    levels[axis] = (uint8_t)(high ? levels[axis] | which : levels[axis] & ~which);
    if (listening && !waiting && axis == listened_axis && which == SWITCH_HOME &&
        was_high != high && high == listens_for_high) {
        capture();
    }
}

uint8_t switches_read(uint8_t axis)
{
    return levels[axis];
}

void switch_capture_start(uint8_t axis, bool to_high)
{
    listening = true;
    waiting = false;
    listened_axis = axis;
    listens_for_high = to_high;
}

void switch_capture_stop(void)
{
    listening = false;
    waiting = false;
}

bool switch_capture_waiting(void)
{
    return waiting;
}

bool switch_capture_take(struct switch_capture *capture_taken)
{
    if (!waiting) {
        return false;
    }
    *capture_taken = first;
    waiting = false;
    return true;
}
