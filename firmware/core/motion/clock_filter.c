// SPDX-License-Identifier: MIT
#include "motion/clock_filter.h"

#include "base/apart.h"    // APART
#include "base/multiply.h" // multiply_u32_u16

void clock_filter_aim(struct clock_filter *filter,
                      uint32_t nominal_ticks,
                      uint16_t edges_ahead)
{
    uint8_t shift = CLOCK_FILTER_SHIFT_MIN;

    for (uint16_t most = 5; edges_ahead > most && shift < CLOCK_FILTER_SHIFT_MAX;
         most = (uint16_t)(most * 3u)) {
        shift++;
    }
    filter->nominal_ticks = nominal_ticks;
    filter->shift_final = shift;
    filter->count = 0;
}

// This edge is the first one.
static APART void begin(struct clock_filter *filter, uint32_t edge_ticks)
{
    filter->period = (struct fine_ticks){.ticks = filter->nominal_ticks};
    filter->expected = (struct fine_ticks){.ticks = edge_ticks};
    fine_add(&filter->expected, &filter->period);
    filter->edge++;
    filter->count = 3;
    filter->stage = 0;
    filter->bridged = 0;
}

bool clock_filter_bridge(struct clock_filter *filter)
{
    if (filter->bridged == filter->hold_over) {
        return false;
    }
    filter->bridged++;
    filter->missing++;
    filter->edge++;
    fine_add(&filter->expected, &filter->period);
    return true;
}

static APART void note_error(struct clock_filter *filter, int32_t error)
{
    if (error > INT16_MAX) {
        error = INT16_MAX;
    } else if (error < -INT16_MAX) {
        error = -INT16_MAX;
    }
    filter->error_ticks = (int16_t)error;
    uint16_t size = (uint16_t)(error < 0 ? -error : error);

    if (size > UINT16_MAX / 16u) {
        size = UINT16_MAX / 16u;
    }
    filter->jitter = (uint16_t)(filter->jitter - filter->jitter / 16u + size);
}

// Correct the expected time and the period by the error of the edge, and go on to the next edge.
static APART void correct(struct clock_filter *filter, int32_t error_ticks)
{
    note_error(filter, error_ticks);
    uint8_t stage = filter->stage;
    uint8_t shift = stage < filter->shift_final ? stage : filter->shift_final;
    struct fine_ticks error = {
        .fraction = (uint16_t)-filter->expected.fraction,
        .ticks = (uint32_t)error_ticks - (filter->expected.fraction != 0 ? 1u : 0u),
    };

    fine_halve(&error, shift);
    fine_add(&filter->expected, &error);
    // The second edge gives the period.
    fine_halve(&error, shift == 0 ? 0 : (uint8_t)(shift + 1u));
    fine_add(&filter->period, &error);
    fine_add(&filter->expected, &filter->period);
    filter->edge++;
    filter->bridged = 0;
    if (!clock_filter_settled(filter)) {
        filter->count++;
        if ((filter->count & (filter->count - 1u)) == 0) {
            filter->stage++;
        }
    }
}

bool clock_filter_edge(struct clock_filter *filter, uint32_t edge_ticks)
{
    while (filter->count != 0) {
        int32_t quarter = (int32_t)(filter->period.ticks / 4u);
        int32_t error = (int32_t)(edge_ticks - filter->expected.ticks);

        if (error < -quarter) {
            filter->glitches++;
            if (clock_filter_settled(filter)) {
                return false;
            }
            break;
        }
        if (error <= quarter) {
            correct(filter, error);
            return true;
        }
        if (!clock_filter_bridge(filter)) {
            break;
        }
    }
    begin(filter, edge_ticks);
    return true;
}

uint32_t clock_filter_ahead(const struct clock_filter *filter, uint16_t edges)
{
    edges--;
    // The fractions' sum is below 2^32 for every number of edges.
    uint32_t fraction =
        (uint32_t)filter->period.fraction * edges + filter->expected.fraction + 0x8000u;

    return filter->expected.ticks + multiply_u32_u16(filter->period.ticks, edges) +
           (uint16_t)(fraction >> 16);
}
