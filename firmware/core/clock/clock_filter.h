// SPDX-License-Identifier: MIT
// Tracks the pixel clock: the time of its edges and its period, both smoothed, so that edges to
// come can be predicted. The filter is an alpha-beta filter, in whole numbers and shifts;
// DESIGN.md, "The pixel clock", says what its gains buy. The board has one filter, inside its
// lock_grid; app/axes/reference.c brings it the edges. Times are ticks since the timers started;
// they wrap. Main loop only.
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
// The filter judges its clock. Each false edge and each gap adds to `doubt`, and two good edges in
// a row end the doubt. A clock of another frequency never brings two good edges in a row: the doubt
// grows, and the filter forgets the clock.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "base/fine.h" // struct fine_ticks

// The final shift lies between these two.
#define CLOCK_FILTER_SHIFT_MIN 2u
#define CLOCK_FILTER_SHIFT_MAX 7u

// Edges in a row after which a new phase is trusted. If a false edge gave the phase of a clock that
// comes back, all true edges would look false.
#define CLOCK_FILTER_FRESH_EDGES 3u
// `fresh` of a clock that rests: the next edge gives the phase.
#define CLOCK_FILTER_RESTS (CLOCK_FILTER_FRESH_EDGES + 1u)

// What adds to the doubt: a gap, a false edge, an edge more than an eighth of a period off. Two
// good edges in a row end the doubt. Three false edges are noise; a fourth one, with one good edge
// between each two, shows a clock of twice the frequency. Seven gaps in the same way show a clock
// of half the frequency.
//
//     clock                     what the filter sees                    edges until it is forgotten
//     twice as fast             good, false, good, false, ...           7
//     1.5 times as fast         good, false, a gap and false, ...       4
//     half as fast              a gap before each edge                  7
//     three, four times slower  gaps of two, of three before each       7
//     one of seven is missing   gaps, most of them after good edges     in 100,000 edges two times
//     one false edge of seven   false, most of them after good edges    in 3,000 edges once
#define CLOCK_FILTER_DOUBT_GAP   1u
#define CLOCK_FILTER_DOUBT_FALSE 2u
#define CLOCK_FILTER_DOUBT_FAR   3u
// With more doubt than this the filter forgets the clock.
#define CLOCK_FILTER_DOUBT_MOST 6u
// A bit of `doubt`: the newest edge was good. The next good edge then leaves nothing but this bit.
#define CLOCK_FILTER_CALM 0x80u

// The functions below write the members, except for hold_over. clock_edges.c also counts glitches.
struct clock_filter {
    union {
        struct {
            // Where the next edge is expected, ticks since the timers started.
            struct fine_ticks expected;
            // The smoothed period, ticks.
            struct fine_ticks period;
        };
        // The same two as fine_track() takes them: place and step.
        struct fine_ticks pair[2];
    };
    // The period of the settings, ticks: the period until the second edge has come.
    uint32_t nominal_ticks;
    // Number of the newest edge, missing ones counted; wraps.
    uint16_t edge;
    // 3 more than the edges taken since the first one, until the filter has settled; 0: no first
    // edge has come.
    uint16_t count;
    // Newest edge minus the time expected for it, ticks; positive when the edge came late.
    int32_t error_ticks;
    // Mean magnitude of these errors, in units of 1/16 tick; an error above 4095 ticks counts as
    // 4095.
    uint16_t jitter;
    // Edges where none can be, since reset; wraps.
    uint16_t glitches;
    // Missing edges, since reset; wraps.
    uint16_t missing;
    // Missing edges in a row up to now.
    uint8_t bridged;
    // How many edges in a row may be missing. reference.c sets it from setting hold_over_edges.
    uint8_t hold_over;
    // The present shift of alpha, 0..CLOCK_FILTER_SHIFT_MAX.
    uint8_t shift;
    // The shift of a settled filter, CLOCK_FILTER_SHIFT_MIN..CLOCK_FILTER_SHIFT_MAX.
    uint8_t shift_final;
    // How often `count` must still become a power of two for the filter to have settled.
    uint8_t stages;
    // Edges to come in a row until the phase is trusted, 0..CLOCK_FILTER_FRESH_EDGES;
    // CLOCK_FILTER_RESTS: the phase is not known.
    uint8_t fresh;
    // How much of what came lately does not fit the period, 0..CLOCK_FILTER_DOUBT_MOST, and
    // CLOCK_FILTER_CALM.
    uint8_t doubt;
};

// Forget the clock: the next edge is the first one. The numbers of edges, glitches and missing
// edges go on.
void clock_filter_restart(struct clock_filter *filter);

// The clock rests. The period of a filter that has settled stays; any other filter restarts.
void clock_filter_rest(struct clock_filter *filter);

// Begin again with another nominal period, ticks, for predictions that lie edges_ahead edges ahead.
// The final shift is the smallest with which the noise of these predictions stays below 0.6 of the
// clock's jitter.
void clock_filter_aim(struct clock_filter *filter,
                      uint32_t nominal_ticks,
                      uint16_t edges_ahead);

// An edge came at edge_ticks, ticks since the timers started. Returns true when it was taken as
// edge number filter->edge. Returns false when it was a glitch, more than a quarter of a period
// from each place where an edge can be; of the first interval, more than a sixteenth.
//
//     glitch while the filter settles       the next edge is the first one: nobody can tell which
//                                           of the two edges was false
//     glitch while the phase is fresh       the next edge gives the phase; the period stays
//     more edges missing than hold_over     the clock has rested: this edge gives the phase
//     too much doubt                        the filter restarts and is no longer settled
//
// Edges must come in the order of time. Each missing edge before this one costs some time more.
bool clock_filter_edge(struct clock_filter *filter, uint32_t edge_ticks);

// The expected edge is missing: go on to the next one. Returns false and changes nothing when more
// edges in a row would be missing than hold_over allows, or when no edge is expected, because the
// first one is still to come. clock_filter_edge() does the same where an edge shows that edges
// before it were missing. Where the second edge of all is missing, the filter begins again with the
// next edge, because an interval of two periods is no measure of one.
bool clock_filter_bridge(struct clock_filter *filter);

// True when enough edges have come: 29 after the first one, or more where the final shift is
// larger.
static inline bool clock_filter_settled(const struct clock_filter *filter)
{
    return filter->stages == 0;
}

// Time of the edge that comes `edges` (1 or more) after the newest one, ticks since the timers
// started, rounded to a tick. Only when clock_filter_settled().
uint32_t clock_filter_ahead(const struct clock_filter *filter, uint16_t edges);
