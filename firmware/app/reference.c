// SPDX-License-Identifier: MIT
#include "app/reference.h"

#include "app/settings.h" // settings_now
#include "config.h"       // CONFIG_TIMER_HZ
#include "hal/clock.h"    // clock_now_units

static struct pixel_period clock_period;
static struct clock_watch edge_watch;
static uint32_t edge_seen_units; // when the last clock edge was handled

void reference_apply_settings(void)
{
    const struct settings *settings = settings_now();

    (void)pixel_period_set(&clock_period,
                           CONFIG_TIMER_HZ,
                           settings_u32(settings->pixel_hz_num),
                           settings_u32(settings->pixel_hz_den));
    reference_rest();
}

const struct pixel_period *reference_period(void)
{
    return &clock_period;
}

const struct clock_watch *reference_watch(void)
{
    return &edge_watch;
}

bool reference_present(void)
{
    return edge_watch.known;
}

bool reference_edge(uint32_t edge_ticks, uint32_t *pixel)
{
    reference_await_edge();
    return clock_watch_edge(&edge_watch, &clock_period, edge_ticks, pixel);
}

void reference_edge_dropped(void)
{
    reference_await_edge();
    clock_watch_forget(&edge_watch);
}

void reference_follow(uint32_t zero_ticks)
{
    clock_watch_follow(&edge_watch, &clock_period, zero_ticks);
}

void reference_rest(void)
{
    clock_watch_rest(&edge_watch);
}

void reference_await_edge(void)
{
    edge_seen_units = clock_now_units();
}

// Every round calls this function, so that it must be quick: shifts by whole bytes and a small
// factor.
bool reference_overdue(void)
{
    return clock_now_units() - edge_seen_units >
           clock_period.whole_ticks / 256u * 6u + 7u;
}
