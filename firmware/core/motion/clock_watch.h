// SPDX-License-Identifier: MIT
// Compares pixel clock edges with the places a running line has planned for them. Time is in
// ticks since the timers started and wraps.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "build_features.h"      // FEATURE_CLOCK_STATISTICS
#include "motion/pixel_period.h" // struct pixel_grid

struct clock_watch {
    bool following;      // a line gives the reference
    bool known;          // the place of the edge before is
    uint32_t edges;      // seen since reset
    uint32_t edge_ticks; // place of the newest one
    uint16_t odd; // its distance from the one before, in 256 ticks; 0: as it should be
#if FEATURE_CLOCK_STATISTICS
    uint32_t zero_ticks; // of that line
    uint32_t next_ticks; // planned place of the next edge
    uint32_t pixel;      // number of that edge in the line, 0 = line zero
    int16_t error_ticks; // of the last edge
    uint16_t error_max_ticks;
    struct pixel_grid grid;
#endif
};

// A line begins at zero_ticks. When the period changes, following must end.
void clock_watch_follow(struct clock_watch *watch,
                        const struct pixel_period *period,
                        uint32_t zero_ticks);

// An edge at this time. True when it belongs to a line; *pixel is then its number and
// watch->error_ticks how late it came. In bounded time, however long the clock has rested.
bool clock_watch_edge(struct clock_watch *watch,
                      const struct pixel_period *period,
                      uint32_t edge_ticks,
                      uint32_t *pixel);

// An edge came whose place is not known.
static inline void clock_watch_forget(struct clock_watch *watch)
{
    watch->known = false;
}

// The clock rests: what comes next belongs to no line.
static inline void clock_watch_rest(struct clock_watch *watch)
{
    watch->known = false;
    watch->following = false;
}
