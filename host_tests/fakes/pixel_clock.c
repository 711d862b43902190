// SPDX-License-Identifier: MIT
// A fake of hal/pixel_clock.h with an exact source of edges.
#include "hal/pixel_clock.h"

#include "fakes/board.h"
#include "fakes/board_parts.h"
#include "hal/step_timer.h"      // step_timer_sample
#include "motion/pixel_period.h" // pixel_*

static struct pixel_period period;
static struct pixel_grid grid;
static uint32_t next_ticks; // next edge at the pin
static bool on;
static bool waiting;
static bool overrun;
static struct pixel_capture newest;

void fake_pixel_clock_power_on(void)
{
    on = false;
    waiting = false;
    overrun = false;
}

void fake_pixel_clock(uint32_t first_ticks, uint32_t num, uint32_t den)
{
    on = pixel_period_set(&period, CONFIG_TIMER_HZ, num, den);
    if (on) {
        pixel_grid_start(&grid, &period);
        next_ticks = first_ticks;
    }
}

uint32_t fake_next_edge_ticks(void)
{
    return next_ticks;
}

bool fake_pixel_clock_due(uint32_t *ticks)
{
    *ticks = next_ticks + PIXEL_CLOCK_CAPTURE_DELAY_TICKS;
    return on;
}

void fake_pixel_clock_capture(void)
{
    uint32_t captured = next_ticks + PIXEL_CLOCK_CAPTURE_DELAY_TICKS;

    next_ticks += pixel_grid_advance(&grid);
    if (waiting) {
        overrun = true;
        return;
    }
    waiting = true;
    newest = (struct pixel_capture){
        .ticks = (uint16_t)(captured - fake_timers_period_start(CONFIG_PIXEL_CLOCK_AXIS)),
        .back = 1,
    };
    step_timer_sample(CONFIG_PIXEL_CLOCK_AXIS, &newest.sample);
}

bool pixel_clock_waiting(void)
{
    return waiting;
}

bool pixel_clock_take(struct pixel_capture *capture, bool *lost)
{
    if (!waiting) {
        return false;
    }
    *capture = newest;
    *lost = overrun;
    waiting = false;
    overrun = false;
    return true;
}
