// SPDX-License-Identifier: MIT
#include "clock/clock_filter.h"

#include "base/apart.h"    // APART
#include "base/multiply.h" // multiply_u32_u16

// `count` behind the first edge.
#define FIRST_COUNT 3u

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
    clock_filter_restart(filter);
}

void clock_filter_restart(struct clock_filter *filter)
{
    filter->count = 0;
    filter->stages = 1;
    filter->fresh = 0;
    filter->doubt = 0;
}

APART void clock_filter_rest(struct clock_filter *filter)
{
    filter->bridged = 0;
    if (clock_filter_settled(filter)) {
        filter->fresh = CLOCK_FILTER_RESTS;
    } else {
        clock_filter_restart(filter);
    }
}

// Something came, or did not, that a clock of this period would not do.
static APART void doubt(struct clock_filter *filter, uint8_t more)
{
    filter->doubt = (uint8_t)((filter->doubt & (uint8_t)~CLOCK_FILTER_CALM) + more);
    if (filter->doubt > CLOCK_FILTER_DOUBT_MOST) {
        clock_filter_restart(filter);
    }
}

// An edge more that settles the filter. The shift grows with each power of two, up to its final
// value; two more powers and the filter has settled.
static void grow(struct clock_filter *filter)
{
    filter->count++;
    if ((filter->count & (filter->count - 1u)) == 0) {
        filter->stages--;
        if (filter->stages > 1u) {
            filter->shift++;
        }
    }
}

static void note_error(struct clock_filter *filter, int32_t error_ticks)
{
    uint16_t size = UINT16_MAX / 16u;

    filter->error_ticks = error_ticks;
    if (error_ticks < 0) {
        error_ticks = -error_ticks;
    }
    if ((uint32_t)error_ticks < size) {
        size = (uint16_t)error_ticks;
    }
    filter->jitter = (uint16_t)(filter->jitter - filter->jitter / 16u + size);
}

// Go on to the next edge.
static APART void expect_next(struct clock_filter *filter)
{
    filter->edge++;
    fine_add(&filter->expected, &filter->period);
}

APART bool clock_filter_bridge(struct clock_filter *filter)
{
    if (filter->count == 0 || filter->fresh == CLOCK_FILTER_RESTS ||
        filter->bridged == filter->hold_over) {
        return false;
    }
    filter->bridged++;
    filter->missing++;
    // From the first edge on the nominal period leads nowhere: the next edge is the first one.
    if (filter->count == FIRST_COUNT) {
        filter->count = 0;
    }
    expect_next(filter);
    return true;
}

// more: what this edge adds to the doubt.
static APART void take(struct clock_filter *filter, int32_t error_ticks, uint8_t more)
{
    note_error(filter, error_ticks);
    fine_track(filter->pair, error_ticks, filter->shift);
    expect_next(filter);
    if (filter->fresh != 0) {
        filter->fresh--;
    }
    if (!clock_filter_settled(filter)) {
        grow(filter);
    }
    if (more != 0) {
        filter->bridged = 0;
        doubt(filter, more);
    } else if (filter->doubt >= CLOCK_FILTER_CALM) {
        filter->doubt = CLOCK_FILTER_CALM;
    } else {
        filter->doubt = (uint8_t)(filter->doubt + CLOCK_FILTER_CALM);
    }
}

// This edge gives the phase.
static void expect_behind(struct clock_filter *filter, uint32_t edge_ticks)
{
    filter->expected.ticks = edge_ticks;
    filter->expected.fraction = FINE_TICK_CENTRE;
    expect_next(filter);
    filter->bridged = 0;
}

// This edge is the first one.
static void begin(struct clock_filter *filter, uint32_t edge_ticks)
{
    filter->period.ticks = filter->nominal_ticks;
    filter->period.fraction = 0;
    expect_behind(filter, edge_ticks);
    filter->count = FIRST_COUNT;
    filter->shift = 0;
    filter->stages = (uint8_t)(filter->shift_final + 2u);
}

// A false edge came: drop it.
static void drop(struct clock_filter *filter)
{
    filter->glitches++;
    // Nobody can tell yet which of the two edges was false: the next one is the first.
    if (!clock_filter_settled(filter)) {
        filter->count = 0;
        return;
    }
    if (filter->fresh != 0) {
        clock_filter_rest(filter);
    }
    doubt(filter, CLOCK_FILTER_DOUBT_FALSE);
}

// What an edge in its place adds to the doubt; farther than `most` off it is far.
static inline uint8_t doubt_of(const struct clock_filter *filter,
                               int32_t error_ticks,
                               int32_t most)
{
    if ((uint32_t)(error_ticks + most) > 2u * (uint32_t)most) {
        return CLOCK_FILTER_DOUBT_FAR;
    }
    return (uint8_t)(filter->bridged == 0 ? 0 : CLOCK_FILTER_DOUBT_GAP);
}

bool clock_filter_edge(struct clock_filter *filter, uint32_t edge_ticks)
{
    BY_POINTER(filter);
    while (filter->count != 0 && filter->fresh != CLOCK_FILTER_RESTS) {
        // A quarter of the period. The first interval must be near the nominal one.
        uint8_t shift = filter->count == FIRST_COUNT ? 4u : 2u;
        int32_t most = (int32_t)(filter->period.ticks >> shift);
        int32_t error = (int32_t)(edge_ticks - filter->expected.ticks);

        if (error + most < 0) {
            drop(filter);
            return false;
        }
        if (error <= most) {
            take(filter, error, doubt_of(filter, error, most >> 1));
            return true;
        }
        if (!clock_filter_bridge(filter)) {
            clock_filter_rest(filter);
        }
    }
    if (filter->count == 0) {
        begin(filter, edge_ticks);
    } else {
        expect_behind(filter, edge_ticks);
        filter->fresh = CLOCK_FILTER_FRESH_EDGES;
    }
    return true;
}

uint32_t clock_filter_ahead(const struct clock_filter *filter, uint16_t edges)
{
    edges--;
    // The fractions' sum is below 2^32 for every number of edges.
    uint32_t fraction = multiply_u32_u16(filter->period.fraction, edges) +
                        filter->expected.fraction + 0x8000u;

    return multiply_u32_u16(filter->period.ticks, edges) + filter->expected.ticks +
           (uint16_t)(fraction >> 16);
}
