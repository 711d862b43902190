// SPDX-License-Identifier: MIT
#include "app/axes/mark.h"

#if FEATURE_TOKENS

#include "hal/clock.h" // clock_now_units
#include "hal/uart.h"  // uart_age_units

static struct mark mark;

const struct mark *mark_now(void)
{
    return &mark;
}

void mark_set(void)
{
    mark.units = clock_now_units() - uart_age_units();
    mark.count++;
    mark.steady = true;
}

void mark_started(void)
{
    mark.started_units = clock_now_units();
}

void mark_disturb(void)
{
    mark.steady = false;
}

void mark_zero(uint16_t edge)
{
    mark.zero_edge = edge;
}

#endif
