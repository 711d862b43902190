// SPDX-License-Identifier: MIT
#include "app/reference.h"

#include "app/settings.h" // settings_now
#include "config.h"       // CONFIG_TIMER_HZ
#include "hal/clock.h"    // clock_now_units

static struct pixel_period period;
static struct clock_watch watch;
static uint32_t edge_seen_units; // when the last clock edge was handled

void reference_apply_settings(void)
{
    const struct settings *settings = settings_now();

    (void)pixel_period_set(&period,
                           CONFIG_TIMER_HZ,
                           settings_u32(settings->pixel_hz_num),
                           settings_u32(settings->pixel_hz_den));
    reference_rest();
}

const struct pixel_period *reference_period(void)
{
    return &period;
}

const struct clock_watch *reference_watch(void)
{
    return &watch;
}

bool reference_present(void)
{
    return watch.known;
}

bool reference_edge(uint32_t edge_ticks, uint32_t *pixel)
{
    reference_await_edge();
    return clock_watch_edge(&watch, &period, edge_ticks, pixel);
}

void reference_edge_dropped(void)
{
    reference_await_edge();
    clock_watch_forget(&watch);
}

void reference_follow(uint32_t zero_ticks)
{
    clock_watch_follow(&watch, &period, zero_ticks);
}

void reference_rest(void)
{
    clock_watch_rest(&watch);
}

void reference_await_edge(void)
{
    edge_seen_units = clock_now_units();
}

// Whole bytes and a small factor: every round asks.
bool reference_overdue(void)
{
    return clock_now_units() - edge_seen_units > period.whole_ticks / 256u * 6u + 7u;
}
