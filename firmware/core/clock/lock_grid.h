// SPDX-License-Identifier: MIT
// The pixel edges of lines that are locked to the pixel clock: one grid for all axes of the board.
// Every `divider` edges of the clock make a pixel. A pixel edge gets its time once, by prediction,
// when the first axis begins to decode the pixel before it; the times of the newest ones are kept
// for the other axes, which decode the same pixel a little earlier or later. Main loop only.
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

// Highest bit of a divider.
#define LOCK_GRID_DIVIDER_BIT 0x0200u

struct lock_grid {
    struct clock_filter filter;
    // Lines that wait for the clock follow it to their end. Not set: from line zero on they do not.
    bool locks;
    // No line waits for the clock.
    bool ignored;
    // Clock edges of a pixel.
    uint16_t divider;
    // A pixel edge is fixed at most this many clock edges and one pixel ahead.
    uint16_t lead_edges;
#if SEVERAL_AXES
    // Added to lead_edges for a line whose line zero is known: time after a missing edge.
    uint16_t more_edges;
#endif
    // The newest pixel edge that has its time, and the number of its clock edge.
    uint16_t newest;
    uint16_t newest_edge;
    // The next pixel edge whose clock edge is still to come, and the number of its clock edge.
    uint16_t due;
    uint16_t due_edge;
    // A locked pixel may be this much longer or shorter than the pixel of the settings, ticks.
    uint32_t slack_ticks;
    // The clock's period may be this much longer or shorter than its nominal period, ticks.
    uint32_t tolerance_ticks;
    // A pixel of a line that waits.
    struct fine_ticks waiting;
    // The pixel period of the settings.
    struct pixel_period pixel;
    // Times of the newest pixel edges, by their numbers.
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

// The walk of one line along its pixel edges.
struct line_grid {
    // enum line_grid_mode.
    uint8_t mode;
    // Number of the pixel edge reached; line zero has number 0 while the line waits.
    uint16_t edge;
    union {
        // While LINE_GRID_EXACT.
        struct pixel_grid exact;
        // Else the time of that pixel edge, counted from line zero while the line waits.
        struct fine_ticks reached;
    };
};

// The board's grid. The assembler names it, too.
extern struct lock_grid lock_grid;
struct lock_grid *lock_grid_now(void);

// The period of the clock may be this much longer or shorter than nominal. Call it when `pixel` and
// `divider` are set.
void lock_grid_tolerate(uint32_t tolerance_ticks);

// Walk along an exact grid.
void line_grid_start_exact(struct line_grid *grid, const struct pixel_period *period);
// Wait for line zero on the clock's grid.
void line_grid_start_locked(struct line_grid *grid);

// True when the line is locked to the clock.
static inline bool line_grid_locked(const struct line_grid *grid)
{
    return grid->mode != LINE_GRID_EXACT;
}

// Go to the next pixel edge. Returns the ticks from the one before.
uint32_t line_grid_advance(struct line_grid *grid);

// Parts of line_grid_advance(). A pixel of `ticks` has brought the line to an edge of the clock:
// shift the edge until the pixel keeps to its limits. Returns the pixel's ticks afterwards.
uint32_t line_grid_limit(struct line_grid *grid, uint32_t ticks);
// The line waits for line zero: its pixel has the held period.
uint32_t line_grid_wait(struct line_grid *grid);

// True when the clock has not come near enough to the edge reached for the line to go on. A line
// whose pieces run ahead of the pixels must go on a pixel earlier.
bool line_grid_early(const struct line_grid *grid, bool runs_ahead);

// A line is armed while no other one waits: fix the period of pixels of waiting lines.
void lock_grid_hold_period(void);

// Number the pixel edges again: 0 is the clock edge that comes `edges` after the newest one. No
// locked line may be running. Returns the time of edge 0.
uint32_t lock_grid_begin(uint16_t edges);

// Fix one more pixel edge. Returns its time; its number is lock_grid_now()->newest.
uint32_t lock_grid_next(void);

#if SEVERAL_AXES
// Time of pixel edge `number`: one of the LOCK_GRID_EDGES newest that are fixed.
uint32_t lock_grid_time(uint16_t number);
#endif

// Line zero of a waiting line is pixel edge `number`, at this time.
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

// Lines follow the clock from its newest edge on, however many came before.
void lock_grid_follow_from_here(void);

// The clock's period is within the tolerance, or is not known yet.
bool lock_grid_tolerates(void);

// The clock edge that the filter took last is a pixel edge: store its number. Once for each edge
// taken.
bool lock_grid_passes(uint16_t *number);
