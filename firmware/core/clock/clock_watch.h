// SPDX-License-Identifier: MIT
// Compares the edges of the pixel clock with the times that a running line has planned for them.
// Times are ticks since the timers started; they wrap. Main loop only.
//
//     planned   |0        |1        |2        |3        |4        clock_watch_follow()
//     edges     |         |                   |         |         clock_watch_edge()
//                                   ^ missed: 2 is passed over, and 3 is compared with 3
//     belongs to n: no more than half a period away from its planned time
//
// Without FEATURE_CLOCK_STATISTICS edges are counted and their distances are compared with the
// period, but no edge is compared with a plan.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "build_features.h"     // FEATURE_CLOCK_STATISTICS
#include "clock/pixel_period.h" // struct pixel_grid

struct clock_watch {
    // A line is the reference: its planned edges are compared.
    bool following;
    // The time of the previous edge is known.
    bool known;
    // Edges seen since reset, those whose time is not known included; wraps.
    uint32_t edges;
    // Time of the newest edge.
    uint32_t edge_ticks;
    // Distance of the newest edge from the one before, in units of 256 ticks, when that distance is
    // off by more than a sixteenth of the period; else 0. 65535: that or more.
    uint16_t odd;
#if FEATURE_CLOCK_STATISTICS
    // Line zero of the reference line.
    uint32_t zero_ticks;
    // Planned time of the next edge.
    uint32_t next_ticks;
    // The newest edge is known, came in the right distance from the one before, and its error is
    // less than half a period, 0x3FF0 at most.
    bool near;
    // Less than a thirty-second of the period, 0x3FF at most: two edges whose errors differ by less
    // are no odd distance apart.
    uint16_t near_ticks;
    // Number of the pixel edge at or before the newest edge in the line; 0: line zero. Wraps.
    uint16_t pixel;
    // Clock edges of a pixel; 0 means 1. The reference line must end before it changes.
    uint16_t divider;
    // Clock edges since that pixel edge.
    uint16_t phase;
    // Error of the last edge, ticks; positive when it came late.
    int16_t error_ticks;
    // Largest magnitude of the error in this line.
    uint16_t error_max_ticks;
    // The planned times.
    struct pixel_grid grid;
#endif
};

// A line that begins at zero_ticks becomes the reference; the errors of the line before are
// forgotten. The line must end (clock_watch_rest()) before the period changes.
void clock_watch_follow(struct clock_watch *watch,
                        const struct pixel_period *period,
                        uint32_t zero_ticks);

// An edge came at edge_ticks. Returns true when the edge is a pixel edge of the reference line;
// *pixel is then its number (0: line zero) and watch->error_ticks its error. A line that misses
// more than four edges in a row is the reference no longer, so that the time is bounded however
// long the clock has rested.
bool clock_watch_edge(struct clock_watch *watch,
                      const struct pixel_period *period,
                      uint32_t edge_ticks,
                      uint16_t *pixel);

#if FEATURE_CLOCK_STATISTICS
// The newest edge came this many ticks later than planned.
void clock_watch_note(struct clock_watch *watch, int32_t error_ticks);
#endif

// An edge came, of a line that is judged elsewhere: count it, and compare the interval since the
// edge before with the clock's period (watch->odd).
void clock_watch_interval(struct clock_watch *watch,
                          uint32_t period_ticks,
                          uint32_t edge_ticks);

// An edge came whose time is not known: the next distance cannot be judged. The line stays the
// reference.
static inline void clock_watch_forget(struct clock_watch *watch)
{
    watch->known = false;
#if FEATURE_CLOCK_STATISTICS
    watch->near = false;
#endif
}

// The clock rests: the next edge belongs to no line.
static inline void clock_watch_rest(struct clock_watch *watch)
{
    clock_watch_forget(watch);
    watch->following = false;
}
