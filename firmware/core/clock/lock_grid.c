// SPDX-License-Identifier: MIT
#include "clock/lock_grid.h"

#include "base/apart.h"     // APART
#include "base/multiply.h"  // multiply_u32_u16
#include "build_features.h" // FEATURE_CLOCK_STATISTICS

#define INDEX(number) ((uint8_t)(number) & (LOCK_GRID_EDGES - 1u))

// Before line zero several axes are decoded so many times as long ahead as later: the pieces of a
// ramp that takes up backlash can cost them more than a pixel's time. Slow pixels need no more than
// the one edge that each line is ahead.
#define WAITING_LEADS 4u

static struct lock_grid lock_grid;

struct lock_grid *lock_grid_now(void)
{
    return &lock_grid;
}

void line_grid_start_exact(struct line_grid *grid, const struct pixel_period *period)
{
    grid->mode = LINE_GRID_EXACT;
    pixel_grid_start(&grid->exact, period);
}

void line_grid_start_locked(struct line_grid *grid)
{
    grid->mode = LINE_GRID_WAITS;
    grid->edge = 0;
    grid->reached = (struct fine_ticks){.ticks = 0};
}

APART void lock_grid_tolerate(uint32_t tolerance_ticks)
{
    struct lock_grid *grid = &lock_grid;
    // A little more than the tolerance, so that a clock at its limit can still be caught up with.
    uint32_t slack =
        multiply_u32_u16(tolerance_ticks + tolerance_ticks / 64u + 1u, grid->divider);

    BY_POINTER(grid);
    grid->tolerance_ticks = tolerance_ticks;
    grid->slack_ticks = slack;
}

// True when a locked pixel may be so long.
static inline bool may_last(uint32_t ticks)
{
    uint32_t off_ticks = ticks - lock_grid.pixel.whole_ticks;

    if ((int32_t)off_ticks < 0) {
        off_ticks = -off_ticks;
    }
    return off_ticks <= lock_grid.slack_ticks;
}

// The length of a locked pixel that would be so long.
static uint32_t limited(uint32_t ticks)
{
    uint32_t shortest_ticks = lock_grid_shortest(&lock_grid);
    uint32_t longest_ticks = lock_grid.pixel.whole_ticks + lock_grid.slack_ticks;

    if ((int32_t)(ticks - shortest_ticks) < 0) {
        return shortest_ticks;
    }
    return ticks > longest_ticks ? longest_ticks : ticks;
}

// A pixel of `ticks` has brought the line to an edge of the clock: shift the edge for this line
// until the pixel keeps to its limits. What is moved here is made up for later within the limits: a
// line that was checked is never too fast. Returns the pixel's ticks afterwards.
static APART_LARGE uint32_t shift_edge(struct line_grid *grid, uint32_t ticks)
{
    uint32_t allowed_ticks = limited(ticks);

    grid->reached.ticks += allowed_ticks - ticks;
    return allowed_ticks;
}

// The line waits for line zero: go on by a pixel of the held period. Returns its ticks.
static APART_LARGE uint32_t advance_waiting(struct line_grid *grid)
{
    uint32_t before = grid->reached.ticks;

    grid->edge++;
    fine_add(&grid->reached, &lock_grid.waiting);
    return grid->reached.ticks - before;
}

// Predict pixel edges up to this one.
static APART_LARGE void predict(uint16_t number)
{
    while ((int16_t)(number - lock_grid.newest) > 0) {
        (void)lock_grid_next();
    }
}

// The time of a pixel edge, which is predicted now if nobody has asked for it before.
static inline uint32_t time_of(uint16_t number)
{
    if (!SEVERAL_AXES || (int16_t)(number - lock_grid.newest) > 0) {
        predict(number);
    }
    return lock_grid.times[INDEX(number)];
}

static APART_LARGE uint32_t advance_locked(struct line_grid *grid)
{
    uint32_t before = grid->reached.ticks;

    grid->reached.ticks = time_of(++grid->edge);
    uint32_t ticks = grid->reached.ticks - before;

    // The question is worth its flash where several axes ask it in each pixel.
    return SEVERAL_AXES && may_last(ticks) ? ticks : shift_edge(grid, ticks);
}

uint32_t line_grid_advance(struct line_grid *grid)
{
    if (grid->mode == LINE_GRID_EXACT) {
        return pixel_grid_advance(&grid->exact);
    }
    return grid->mode == LINE_GRID_LOCKED ? advance_locked(grid) : advance_waiting(grid);
}

bool line_grid_early(const struct line_grid *grid, bool runs_ahead)
{
    const struct lock_grid *lock = &lock_grid;
    uint16_t edges = 1;
    uint16_t beyond = grid->edge;

    if (grid->mode == LINE_GRID_EXACT) {
        return false;
    }
    BY_POINTER(lock);
    // Line zero is on the next edge or later.
    if (grid->mode == LINE_GRID_LOCKED) {
        edges = (uint16_t)(lock->newest_edge - lock->filter.edge);
        beyond = (uint16_t)(beyond - lock->newest);
#if SEVERAL_AXES
        edges = (uint16_t)(edges - lock->more_edges);
#endif
    }
    if (runs_ahead) {
        beyond--;
    }
    uint16_t lead = lock->lead_edges;
    if (SEVERAL_AXES && grid->mode == LINE_GRID_WAITS) {
        lead = (uint16_t)((lead - 1u) * WAITING_LEADS + 1u);
    }
    return (int16_t)(edges + beyond * lock->divider - lead) > 0;
}

void lock_grid_hold_period(void)
{
    lock_grid.waiting = (struct fine_ticks){.ticks = 0};
    for (uint16_t bit = LOCK_GRID_DIVIDER_BIT; bit != 0; bit >>= 1) {
        fine_add(&lock_grid.waiting, &lock_grid.waiting);
        if ((lock_grid.divider & bit) != 0) {
            fine_add(&lock_grid.waiting, &lock_grid.filter.period);
        }
    }
}

// Give pixel edge `newest` its time by prediction.
static APART uint32_t fix_newest(struct lock_grid *grid)
{
    BY_POINTER_SMALL(grid);
    uint16_t edges = (uint16_t)(grid->newest_edge - grid->filter.edge);
    uint32_t ticks = clock_filter_ahead(&grid->filter, edges);

    grid->times[INDEX(grid->newest)] = ticks;
    return ticks;
}

uint32_t lock_grid_begin(uint16_t edges)
{
    struct lock_grid *grid = &lock_grid;

    BY_POINTER(grid);
    grid->newest = 0;
    grid->newest_edge = (uint16_t)(grid->filter.edge + edges);
    if (FEATURE_CLOCK_STATISTICS) {
        grid->due = 0;
        grid->due_edge = grid->newest_edge;
    }
    return fix_newest(grid);
}

uint32_t lock_grid_next(void)
{
    struct lock_grid *grid = &lock_grid;

    BY_POINTER(grid);
    grid->newest++;
    grid->newest_edge = (uint16_t)(grid->newest_edge + grid->divider);
    return fix_newest(grid);
}

#if SEVERAL_AXES
uint32_t lock_grid_time(uint16_t number)
{
    return lock_grid.times[INDEX(number)];
}
#endif

void line_grid_place(struct line_grid *grid, uint16_t number, uint32_t zero_ticks)
{
    BY_POINTER_SMALL(grid);
    grid->mode = LINE_GRID_LOCKED;
    grid->edge = (uint16_t)(grid->edge + number);
    grid->reached.ticks += zero_ticks;
}

#if SEVERAL_AXES
void lock_grid_keep(uint16_t edges, uint32_t zero_ticks)
{
    struct lock_grid *grid = &lock_grid;
    struct fine_ticks reached = {.ticks = zero_ticks};

    for (; edges != 0; edges--) {
        fine_add(&reached, &grid->waiting);
        grid->newest++;
        grid->newest_edge = (uint16_t)(grid->newest_edge + grid->divider);
        grid->times[INDEX(grid->newest)] = reached.ticks;
    }
}
#endif

bool lock_grid_tolerates(void)
{
    uint32_t off = lock_grid.filter.period.ticks - lock_grid.filter.nominal_ticks;

    return !clock_filter_settled(&lock_grid.filter) ||
           off + lock_grid.tolerance_ticks <= 2u * lock_grid.tolerance_ticks;
}

void lock_grid_follow_from_here(void)
{
    if (FEATURE_CLOCK_STATISTICS) {
        lock_grid.due_edge = lock_grid.filter.edge;
    }
}

bool lock_grid_passes(uint16_t *number)
{
    while ((int16_t)(lock_grid.filter.edge - lock_grid.due_edge) > 0) {
        lock_grid.due++;
        lock_grid.due_edge = (uint16_t)(lock_grid.due_edge + lock_grid.divider);
    }
    *number = lock_grid.due;
    return lock_grid.filter.edge == lock_grid.due_edge;
}
