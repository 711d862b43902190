// SPDX-License-Identifier: MIT
#include "clock/clock_out.h"

void clock_out_begin(struct clock_out *clock, uint16_t hz, uint32_t counts_hz)
{
    uint32_t period_counts = (counts_hz + hz / 2u) / hz;

    clock->high_counts = period_counts / 2u;
    clock->low_counts = period_counts - clock->high_counts;
    clock->left_counts = clock->low_counts;
    clock->counts = 0;
    clock->high = false;
}

// Counts to the next match. What is left for the one before an edge must not be too short.
static uint16_t next_counts(uint32_t left_counts)
{
    if (left_counts > CLOCK_OUT_COUNTS_MAX + CLOCK_OUT_COUNTS_MIN) {
        return CLOCK_OUT_COUNTS_MAX;
    }
    if (left_counts > CLOCK_OUT_COUNTS_MAX) {
        return (uint16_t)left_counts / 2u;
    }
    return (uint16_t)left_counts;
}

uint16_t clock_out_match(struct clock_out *clock)
{
    clock->left_counts -= clock->counts;
    if (clock->left_counts == 0) {
        clock->high = !clock->high;
        clock->left_counts = clock->high ? clock->high_counts : clock->low_counts;
    }
    clock->counts = next_counts(clock->left_counts);
    return clock->counts;
}
