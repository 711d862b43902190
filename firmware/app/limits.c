// SPDX-License-Identifier: MIT
#include "app/limits.h"

#include "app/axes.h"      // axes_get
#include "app/reference.h" // reference_*
#include "app/settings.h"  // settings_now

// A change of the clock edge's error by more than this part of a pixel is a deviation.
#define DEVIATION_PARTS 64u

#define TICKS_PER_US ((uint32_t)(CONFIG_TIMER_HZ / 1000000uL))

static struct line_limits current_limits;

void limits_apply_settings(void)
{
    const struct settings *settings = settings_now();
    uint16_t driver_us = settings->dir_setup_us > settings->dir_hold_us
                             ? settings->dir_setup_us
                             : settings->dir_hold_us;
    uint16_t half_ticks =
        (uint16_t)(driver_us * TICKS_PER_US + CONFIG_REVERSAL_MARGIN_TICKS);

    reference_apply_settings();
    uint32_t error_ticks = reference_period()->whole_ticks / DEVIATION_PARTS;
    records_thin(settings->record_every,
                 error_ticks > UINT16_MAX ? UINT16_MAX : (uint16_t)error_ticks);
    current_limits = (struct line_limits){
        .pixel_ticks = reference_period()->whole_ticks,
        .min_interval_ticks = CONFIG_MIN_INTERVAL_TICKS,
        .smooth_min_interval_ticks = CONFIG_SMOOTH_MIN_INTERVAL_TICKS,
        .seek_min_interval_ticks = CONFIG_SEEK_MIN_INTERVAL_TICKS,
        // The direction changes in the middle of an interval, so that half of it must be enough.
        .reversal_min_ticks = (uint16_t)(2u * half_ticks),
        .max_acceleration = settings->max_acceleration,
        .start_stop_steps = settings->start_stop_steps,
    };
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        axes_get(i)->feed.reversal_ticks = half_ticks;
    }
}

const struct line_limits *limits_now(void)
{
    return &current_limits;
}
