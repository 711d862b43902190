// SPDX-License-Identifier: MIT
// Tracks the pixel clock: the time of its edges and its period, both smoothed, so that edges to
// come can be predicted. An alpha-beta filter, in whole numbers and shifts; DESIGN.md, "The pixel
// clock", says what its gains buy. Times are ticks since the timers started; they wrap. Main loop
// only.
//
//     edges       |         |          |                     |       |  |
//     expected    |         |         |          |          |          |
//     error                 0        late                  early
//     taken as    edge     edge      edge      missing     edge   glitch edge
//
//     expected = expected + error / 2^shift                alpha = 2^-shift
//     period   = period + error / 2^(2 * shift + 1)        beta = alpha^2 / 2
//     expected = expected + period
//
// The first two edges give time and period. From there on the shift grows with the number of edges
// from 1 to its final value, so that early edges count as much as they can: 4 / n among n edges.
//
// A clock that rests keeps its period: the first edge after the rest gives the time alone. Until a
// few edges have come in a row, the phase is new: a false edge then begins the rest again.
//
// The filter judges its clock. Each false edge and each gap adds to `doubt`, which two good edges
// in a row end: a clock of another frequency than the filter's has no such two, and is forgotten.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "base/fine.h" // struct fine_ticks

// The final shift lies between these two.
#define CLOCK_FILTER_SHIFT_MIN 2u
#define CLOCK_FILTER_SHIFT_MAX 7u

// Edges in a row after which a new phase is trusted: a false edge among the first ones of a clock
// that comes back would be taken for a true one, and all true ones for false.
#define CLOCK_FILTER_FRESH_EDGES 3u
// `fresh` of a clock that rests: the next edge gives the phase.
#define CLOCK_FILTER_RESTS (CLOCK_FILTER_FRESH_EDGES + 1u)

// What adds to the doubt: a gap, a false edge, an edge more than an eighth of a period off. Two
// good edges in a row end it. Three false edges are noise; the fourth, with a good one between each
// two, is a clock of twice the frequency, and so are seven gaps one of half.
//
//     clock                     what the filter sees                    edges until it is forgotten
//     twice as fast             good, false, good, false, ...           7
//     1.5 times as fast         good, false, a gap and false, ...       4
//     half as fast              a gap before each edge                  7
//     three, four times slower  gaps of two, of three before each       7
//     one of seven is missing   gaps, most of them behind good edges    in 100,000 edges two times
//     one false edge of seven   false, most of them behind good edges   in 3,000 edges once
#define CLOCK_FILTER_DOUBT_GAP   1u
#define CLOCK_FILTER_DOUBT_FALSE 2u
#define CLOCK_FILTER_DOUBT_FAR   3u
#define CLOCK_FILTER_DOUBT_MOST  6u
// `doubt`, or a part of it: the newest edge was good.
#define CLOCK_FILTER_CALM 0x80u

struct clock_filter {
    union {
        struct {
            // Where the next edge is expected.
            struct fine_ticks expected;
            struct fine_ticks period;
        };
        struct fine_ticks pair[2];
    };
    // The period of the settings, for the first edge.
    uint32_t nominal_ticks;
    // Number of the newest edge, missing ones counted; wraps.
    uint16_t edge;
    // 3 more than the edges taken since the filter began, until it has settled; 0: it has not
    // begun.
    uint16_t count;
    // Newest edge minus the time expected for it, ticks.
    int32_t error_ticks;
    // Mean magnitude of these errors, in units of 1/16 tick; of errors above 4095 ticks, that many.
    uint16_t jitter;
    // Edges where none can be, and missing edges, since reset; they wrap.
    uint16_t glitches;
    uint16_t missing;
    // Missing edges in a row, now and at most.
    uint8_t bridged;
    uint8_t hold_over;
    uint8_t shift;
    uint8_t shift_final;
    // How often count must still become a power of two for the filter to have settled.
    uint8_t stages;
    // Edges to come in a row until the phase is trusted; CLOCK_FILTER_RESTS: it is not known.
    uint8_t fresh;
    // How much of what came lately does not fit the period.
    uint8_t doubt;
};

// Forget the clock: the next edge is the first one. Counts of glitches and missing edges stay.
void clock_filter_restart(struct clock_filter *filter);

// The clock rests. The period of a filter that has settled stays; any other filter restarts.
void clock_filter_rest(struct clock_filter *filter);

// Begin again with another nominal period, for predictions that lie this many edges ahead. The
// final shift is the smallest with which their noise stays below 0.6 of the clock's jitter.
void clock_filter_aim(struct clock_filter *filter,
                      uint32_t nominal_ticks,
                      uint16_t edges_ahead);

// An edge came. Returns true when it is edge number filter->edge, and false when it was a glitch:
// more than a quarter of a period from each place where an edge can be. After a glitch while it
// settles, or while its phase is fresh, the filter begins again with the next edge: a false edge
// close to a true one would spoil the first interval. After more missing edges in a row than
// hold_over allows the clock has rested, and this edge is the first one after the rest. Too much
// doubt restarts the filter: it is no longer settled.
bool clock_filter_edge(struct clock_filter *filter, uint32_t edge_ticks);

// The expected edge is missing: go on to the next one. Returns false when more edges in a row are
// missing than hold_over allows, or when none is expected, because the first one is still to come.
// clock_filter_edge() does the same where an edge shows that edges before it were missing. Where
// the second edge of all is missing, the filter begins again with the next edge: an interval of two
// periods is no measure of one.
bool clock_filter_bridge(struct clock_filter *filter);

// Enough edges have come: 29 after the first one, or more where the final shift is larger.
static inline bool clock_filter_settled(const struct clock_filter *filter)
{
    return filter->stages == 0;
}

// Time of the edge that comes `edges` after the newest one, 1 or more, rounded to a tick. Only
// when clock_filter_settled().
uint32_t clock_filter_ahead(const struct clock_filter *filter, uint16_t edges);
