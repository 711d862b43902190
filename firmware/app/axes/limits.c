// SPDX-License-Identifier: MIT
#include "app/axes/limits.h"

#include "app/axes/axes.h"         // axes_get
#include "app/axes/gate.h"         // gate_unsure
#include "app/axes/reference.h"    // reference_*
#include "app/settings/settings.h" // settings_now
#include "base/apart.h"            // APART, BY_POINTER
#include "base/flash.h"            // flash_word
#include "clock/lock_grid.h"       // lock_grid_now
#include "hal/clock_out.h"         // clock_out_set

// A change of the clock edge's error by more than this part of a pixel is a deviation.
#define DEVIATION_PARTS 64u

#define TICKS_PER_US ((uint32_t)(CONFIG_TIMER_HZ / 1000000uL))

static struct line_limits current_limits;

// The shortest pixel that a line may get.
static uint32_t shortest_pixel_ticks(void)
{
    const struct lock_grid *grid = lock_grid_now();

    return grid->locks ? lock_grid_shortest(grid) : grid->pixel.whole_ticks;
}

void limits_apply_settings(void)
{
    limits_try_settings();
    reference_measure_anew();
    clock_out_set(settings_now()->clock_out_hz);
}

APART void limits_try_settings(void)
{
    // First, so that nothing is kept in registers meanwhile.
    reference_apply_settings();
    gate_unsure();
    const struct settings *settings = settings_now();
    const struct pixel_period *period = reference_period();
    struct line_limits *limits = &current_limits;
    BY_POINTER(period);
    BY_POINTER(limits);
    uint32_t error_ticks = period->whole_ticks / DEVIATION_PARTS;
    records_thin(settings->record_every,
                 error_ticks > UINT16_MAX ? UINT16_MAX : (uint16_t)error_ticks);
    uint16_t driver_us = settings->dir_setup_us > settings->dir_hold_us
                             ? settings->dir_setup_us
                             : settings->dir_hold_us;
    uint16_t half_ticks =
        (uint16_t)(driver_us * TICKS_PER_US + CONFIG_REVERSAL_MARGIN_TICKS);

    // With several axes they follow from how many move, and stay what they are for a line whose
    // head changes the divider.
    if (CONFIG_AXES == 1) {
        limits->min_interval_ticks = CONFIG_MIN_INTERVAL_TICKS;
        limits->smooth_min_interval_ticks = CONFIG_SMOOTH_MIN_INTERVAL_TICKS;
    }
    limits->seek_min_interval_ticks = CONFIG_SEEK_MIN_INTERVAL_TICKS;
    limits->pixel_ticks = shortest_pixel_ticks();
#if FEATURE_LINE_DIVIDER
    limits->divider = settings->divider;
#endif
    // The direction changes in the middle of an interval, so that half of it must be enough.
    limits->reversal_min_ticks = (uint16_t)(2u * half_ticks);
    limits->max_acceleration = settings->max_acceleration;
    limits->start_stop_steps = settings->start_stop_steps;
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        axes_get(i)->feed.reversal_ticks = half_ticks;
    }
}

#if CONFIG_AXES == 1
const struct line_limits *limits_together(uint8_t axes)
{
    (void)axes;
    return &current_limits;
}

const struct line_limits *limits_of(uint8_t axis)
{
    (void)axis;
    return &current_limits;
}
#else
static const uint16_t shortest_ticks[] IN_FLASH = {BOARD_MIN_INTERVAL_1_TICKS,
                                                   BOARD_MIN_INTERVAL_2_TICKS,
                                                   BOARD_MIN_INTERVAL_3_TICKS,
                                                   BOARD_MIN_INTERVAL_TICKS};
static const uint16_t shortest_smooth_ticks[] IN_FLASH = {
    BOARD_SMOOTH_MIN_INTERVAL_1_TICKS,
    BOARD_SMOOTH_MIN_INTERVAL_2_TICKS,
    BOARD_SMOOTH_MIN_INTERVAL_3_TICKS,
    BOARD_SMOOTH_MIN_INTERVAL_TICKS};
_Static_assert(CONFIG_AXES <= sizeof shortest_ticks / sizeof shortest_ticks[0],
               "an interval for every number of axes");

const struct line_limits *limits_together(uint8_t axes)
{
    uint8_t i = axes == CONFIG_AXES ? 3u : 0u;

    if (axes != 0 && axes != CONFIG_AXES) {
        i = (uint8_t)(axes - 1u);
    }
    current_limits.min_interval_ticks = flash_word(&shortest_ticks[i]);
    current_limits.smooth_min_interval_ticks = flash_word(&shortest_smooth_ticks[i]);
    return &current_limits;
}

const struct line_limits *limits_of(uint8_t axis)
{
    uint8_t moving = 0;

    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        moving = (uint8_t)(moving + (lifecycle_moving(&axes_get(i)->life) ? 1u : 0u));
    }
    return limits_together(lifecycle_moving(&axes_get(axis)->life) ? moving : 1u);
}
#endif
