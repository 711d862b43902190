// SPDX-License-Identifier: MIT
// Compares the edges of the pixel clock with the times that a running line has planned for them:
// the board's measure of how well its lines and the clock agree. The board has one watch, in
// app/axes/reference.c, which follows one line at a time. Lines that are locked to the clock have
// no plan of their own; of them the watch takes the filter's errors (clock_watch_note()). Times are
// ticks since the timers started; they wrap. Main loop only.
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
    // Edges seen since reset, those whose time is not known included; wraps. reference.c also
    // counts the latter here.
    uint32_t edges;
    // Time of the newest edge whose time is known, ticks.
    uint32_t edge_ticks;
    // Distance of the newest edge from the one before, in units of 256 ticks and odd, when that
    // distance is off by more than a sixteenth of the period; else 0. 65535: that or more.
    uint16_t odd;
#if FEATURE_CLOCK_STATISTICS
    // Line zero of the reference line, ticks.
    uint32_t zero_ticks;
    // Planned time of the next edge, ticks.
    uint32_t next_ticks;
    // The time of the newest edge is known, the edge came in the right distance from the one
    // before, and its error is less than half a period, 0x3FF0 ticks at most.
    bool near;
    // A tick less than a thirty-second of the period, 0x3FF ticks at most: two edges whose errors
    // differ by no more are no odd distance apart.
    uint16_t near_ticks;
    // Number of the pixel edge at or before the newest edge in the line; 0: line zero. Wraps.
    uint16_t pixel;
    // Clock edges of a pixel; 0 means 1. reference.c sets it. The reference line must end before it
    // changes.
    uint16_t divider;
    // Clock edges since that pixel edge, 0..divider-1.
    uint16_t phase;
    // Error of the last edge, ticks, -32767..32767; positive when it came late.
    int16_t error_ticks;
    // Largest magnitude of the error in this line, ticks.
    uint16_t error_max_ticks;
    // The planned times, one for each edge of the clock.
    struct pixel_grid grid;
#endif
};

// A time in units of 256 ticks, as faults show it, modulo 2^16. Put together from bytes: of a shift
// the compiler makes twice as much.
static inline uint16_t clock_watch_units(uint32_t ticks)
{
    return (uint16_t)((uint16_t)(uint8_t)(ticks >> 16) << 8 | (uint8_t)(ticks >> 8));
}

// A line that begins at zero_ticks becomes the reference; the errors of the line before are
// forgotten. period: exact period of the clock's edges. It must last as long as the watch, and the
// line must end (clock_watch_rest()) before the period changes. Line zero is itself a planned edge.
void clock_watch_follow(struct clock_watch *watch,
                        const struct pixel_period *period,
                        uint32_t zero_ticks);

// An edge came at edge_ticks: count it, compare its interval with the period, and compare the edge
// with the plan. Returns true when the edge is a pixel edge of the reference line; *pixel is then
// its number modulo 2^16 (0: line zero) and watch->error_ticks its error. Edges before line zero,
// by more than half a period, belong to no line. A line that misses more than four edges in a row
// is the reference no longer, so that the time is bounded however long the clock has rested. Only
// in images with FEATURE_CLOCK_STATISTICS. period: as clock_watch_follow() had it.
bool clock_watch_edge(struct clock_watch *watch,
                      const struct pixel_period *period,
                      uint32_t edge_ticks,
                      uint16_t *pixel);

#if FEATURE_CLOCK_STATISTICS
// Note an error that was found elsewhere: the newest edge came error_ticks later than planned. What
// does not fit 16 bits counts as 32767 or -32767.
void clock_watch_note(struct clock_watch *watch, int32_t error_ticks);
#endif

// An edge came at edge_ticks that is not compared with a plan: count it, and compare the interval
// since the edge before with the clock's period, ticks (watch->odd).
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
