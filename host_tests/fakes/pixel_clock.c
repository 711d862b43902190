// SPDX-License-Identifier: MIT
// A fake of hal/pixel_clock.h with an exact source of edges.
#include "hal/pixel_clock.h"

#include "clock/pixel_period.h" // pixel_*
#include "fakes/board.h"
#include "fakes/board_parts.h"
#include "hal/step_timer.h" // step_timer_sample

static struct pixel_period period;
static struct pixel_grid grid;
static uint32_t next_ticks; // next edge at the pin
static bool on;
static struct pixel_capture queue[CONFIG_CLOCK_EDGES]; // the oldest first
static uint8_t queued;
static uint8_t lost;
static bool crowded;

void fake_pixel_clock_power_on(void)
{
    on = false;
    queued = 0;
    lost = 0;
    crowded = false;
}

void fake_crowded_edge(void)
{
    crowded = true;
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
    if (queued == CONFIG_CLOCK_EDGES) {
        lost++;
        return;
    }
    struct pixel_capture *newest = &queue[queued];
    *newest = (struct pixel_capture){
        .ticks = (uint16_t)(captured - fake_timers_period_start(CONFIG_PIXEL_CLOCK_AXIS)),
        .back = 1,
    };
    step_timer_sample(CONFIG_PIXEL_CLOCK_AXIS, &newest->sample);
    queued++;
}

bool pixel_clock_waiting(void)
{
    return queued != 0;
}

bool pixel_clock_take(struct pixel_capture *capture)
{
    if (queued == 0) {
        return false;
    }
    *capture = queue[0];
    queued--;
    for (uint8_t i = 0; i < queued; i++) {
        queue[i] = queue[i + 1u];
    }
    return true;
}

bool pixel_clock_any_lost(void)
{
    return lost != 0 || crowded;
}

uint8_t pixel_clock_take_lost(void)
{
    uint8_t count = lost;

    lost = 0;
    return count;
}

bool pixel_clock_take_crowded(void)
{
    bool found = crowded;

    crowded = false;
    return found;
}

bool pixel_clock_drop(void)
{
    bool any = queued != 0;

    queued = 0;
    lost = 0;
    crowded = false;
    return any;
}
