// SPDX-License-Identifier: MIT
// The pixel edges of lines that are locked to the pixel clock: one grid for all axes of the board.
// Every `divider` edges of the clock make a pixel. A pixel edge gets its time once, by prediction,
// when the first axis begins to decode the pixel before it; the times of the newest ones are kept
// for the other axes, which decode the same pixel a little earlier or later. line.c walks along the
// grid (struct line_grid), reference.c configures it and brings the edges, app/motion begins it
// with the first line. Main loop only.
//
//     clock's edges   |   |   |   |   |   |   |   :   :   :   :   :      (divider 2)
//     number          0       1       2       3       4       5
//     time of it     kept    kept    kept    kept   fixed, predicted
//     a line          |- n1 --|- n2 --|- n3 --|- n4 --|
//                                           now
//
// A line that waits for its line zero is decoded ahead too: its pixels have the period that the
// filter had when the first of the waiting lines was armed.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "build_features.h"     // SEVERAL_AXES
#include "clock/clock_filter.h" // struct clock_filter
#include "clock/pixel_period.h" // struct pixel_grid

// Pixel edges whose times are kept, a power of two, for axes that are not decoded equally far: more
// than any axis is decoded ahead. The build sets 1 where there is one axis.
#if !defined(LOCK_GRID_EDGES)
#define LOCK_GRID_EDGES 16
#endif

// Highest bit that a divider may have.
#define LOCK_GRID_DIVIDER_BIT 0x0200u

// reference.c writes the settings among the members: `locks` to more_edges, and `pixel`. The
// functions below write the others. Numbers of pixel edges and of clock edges wrap at 2^16.
struct lock_grid {
    // The clock's filter, which numbers the clock's edges.
    struct clock_filter filter;
    // Lines that wait for the clock follow it to their end. Not set: from line zero on they do not.
    bool locks;
    // No line waits for the clock.
    bool ignored;
    // Clock edges of a pixel, 1..1000.
    uint16_t divider;
    // A pixel edge is fixed at most this many clock edges and one pixel ahead.
    uint16_t lead_edges;
#if SEVERAL_AXES
    // Added to lead_edges for a line whose line zero is known, clock edges: time after a missing
    // edge.
    uint16_t more_edges;
#endif
    // Number of the newest pixel edge that has its time.
    uint16_t newest;
    // Number of that pixel edge's clock edge.
    uint16_t newest_edge;
    // Number of the next pixel edge whose clock edge is still to come. Only in images with
    // FEATURE_CLOCK_STATISTICS, like due_edge.
    uint16_t due;
    // Number of that pixel edge's clock edge.
    uint16_t due_edge;
    // A locked pixel may be this much longer or shorter than the pixel of the settings, ticks.
    uint32_t slack_ticks;
    // The clock's period may be this much longer or shorter than its nominal period, ticks.
    uint32_t tolerance_ticks;
    // Length of a pixel of a line that waits, ticks.
    struct fine_ticks waiting;
    // The pixel period of the settings.
    struct pixel_period pixel;
    // Times of the newest pixel edges, ticks since the timers started, by the low bits of their
    // numbers.
    uint32_t times[LOCK_GRID_EDGES];
};

// The shortest locked pixel, ticks.
static inline uint32_t lock_grid_shortest(const struct lock_grid *grid)
{
    return grid->pixel.whole_ticks - grid->slack_ticks;
}

enum line_grid_mode {
    // Multiples of the exact period.
    LINE_GRID_EXACT,
    // Locked, and line zero is not known yet.
    LINE_GRID_WAITS,
    // Locked.
    LINE_GRID_LOCKED,
};

// The walk of one line along its pixel edges. The functions below write it.
struct line_grid {
    // enum line_grid_mode.
    uint8_t mode;
    // Number of the pixel edge reached, modulo 2^16; line zero has number 0 while the line waits.
    // Means nothing while LINE_GRID_EXACT.
    uint16_t edge;
    union {
        // While LINE_GRID_EXACT.
        struct pixel_grid exact;
        // Else the time of that pixel edge: ticks since the timers started, or since line zero
        // while the line waits.
        struct fine_ticks reached;
    };
};

// The board's grid.
struct lock_grid *lock_grid_now(void);

// The period of the clock may be tolerance_ticks longer or shorter than nominal. Sets the slack of
// a pixel, which is a little more than the divider times that. To be called when `divider` is set.
void lock_grid_tolerate(uint32_t tolerance_ticks);

// Begin to walk along an exact grid. period: must last as long as the walk.
void line_grid_start_exact(struct line_grid *grid, const struct pixel_period *period);
// Begin to walk along the clock's grid, whose line zero is not known yet. lock_grid_hold_period()
// must have fixed the length of a pixel by the first line_grid_advance().
void line_grid_start_locked(struct line_grid *grid);

// True when the line is locked to the clock, before or after its line zero is known.
static inline bool line_grid_locked(const struct line_grid *grid)
{
    return grid->mode != LINE_GRID_EXACT;
}

// Go to the next pixel edge. Returns the ticks from the one before. Of a locked line this gives the
// edge its time, if no other line has: only when line_grid_early() is false.
uint32_t line_grid_advance(struct line_grid *grid);

// True when the clock has not come near enough to the edge reached for the line to go on. A line
// whose pieces run ahead of the pixels must go on a pixel earlier. Always false of an exact grid.
bool line_grid_early(const struct line_grid *grid, bool runs_ahead);

// A line is armed while no other one waits: fix the length of pixels of waiting lines, which is the
// divider times the filter's present period. The filter must have settled.
void lock_grid_hold_period(void);

// Number the pixel edges again: 0 is the clock edge that comes `edges` (1 or more) after the newest
// one. No locked line may be running, and the filter must have settled. Returns the time of edge 0,
// ticks since the timers started.
uint32_t lock_grid_begin(uint16_t edges);

// Fix one more pixel edge. Returns its time, ticks since the timers started; its number is
// lock_grid_now()->newest.
uint32_t lock_grid_next(void);

#if SEVERAL_AXES
// Time of pixel edge `number`: one of the LOCK_GRID_EDGES newest that are fixed.
uint32_t lock_grid_time(uint16_t number);
#endif

// Line zero of a waiting line is pixel edge `number`, at zero_ticks, ticks since the timers
// started: LINE_GRID_WAITS becomes LINE_GRID_LOCKED.
void line_grid_place(struct line_grid *grid, uint16_t number, uint32_t zero_ticks);

// Pixel edges that a placed line had decoded before its line zero, edge `number` of the grid, was
// known: none of them is to be predicted.
static inline uint16_t line_grid_decoded(const struct line_grid *grid, uint16_t number)
{
    return grid->mode == LINE_GRID_LOCKED ? (uint16_t)(grid->edge - number) : 0;
}

// After lock_grid_begin(): the first `edges` pixel edges, LOCK_GRID_EDGES at most, keep the times
// with which a line was decoded ahead, whatever the filter says. Lines that were not decoded that
// far then get the same times. On boards of several axes.
void lock_grid_keep(uint16_t edges, uint32_t zero_ticks);

// lock_grid_passes() counts from the clock's newest edge on, however many edges came before.
void lock_grid_follow_from_here(void);

// True when the clock's period is within the tolerance, or is not known yet. A predicate: the
// caller latches the fault.
bool lock_grid_tolerates(void);

// True when the clock edge that the filter took last is a pixel edge. *number gets the number of
// the newest pixel edge in any case. To be called once for each edge taken. Images with
// FEATURE_CLOCK_STATISTICS only.
bool lock_grid_passes(uint16_t *number);
