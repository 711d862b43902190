// SPDX-License-Identifier: MIT
#include "app/axes/reference.h"

#include "app/axes/axes.h"         // axes_any_running
#include "app/settings/settings.h" // settings_now
#include "base/apart.h"            // BY_POINTER
#include "base/divide.h"           // divide_u32_u16
#include "clock/lock_grid.h"       // lock_grid_now
#include "hal/clock.h"             // clock_now_units
#include "hal/pixel_clock.h"       // pixel_clock_waiting
#include "stream/stream.h"         // STREAM_WAYPOINTS

// Time for decoding a pixel of a locked line before it begins: 8 ms on every board. Boards that fix
// a pixel edge equally many clock edges ahead have equal grids.
#define LEAD_TICKS ((uint32_t)(CONFIG_TIMER_HZ / 15625u * 128u))
#define PPM        ((uint32_t)1000000)
// A line gets its place when line zero is so near: two idle periods that are loaded already, and
// 4.6 ms for the main loop to come by and release the line; a reply being built takes two.
#define PLACE_TICKS ((uint32_t)0x14000)
_Static_assert(PLACE_TICKS / PIXEL_PERIOD_MIN_TICKS < UINT8_MAX, "place_edges is a byte");

static struct pixel_period clock_period; // of the clock's edges
static struct clock_watch edge_watch;
static uint32_t edge_seen_units; // when the last clock edge was handled

#define FAST_TICKS ((uint32_t)0x4000) // 976 Hz at 16 MHz
#if SEVERAL_AXES
static bool fast; // edges come in this or less
#else
#define FAST_EDGES (PLACE_TICKS / FAST_TICKS + 1u) // place_edges of such a clock, or more
#endif
static bool edge_came;      // since reference_overdue() looked at the time
static uint8_t place_edges; // clock edges in PLACE_TICKS, and one

// Edges in so many ticks, and one.
static APART uint16_t edges_in(uint32_t ticks)
{
    return (uint16_t)(ticks / clock_period.whole_ticks + 1u);
}

// A pixel is decoded when an edge has come that lies one edge and so many ticks before the pixel,
// as far as the stream's waypoints go.
static uint16_t edges_ahead(uint32_t lead_ticks, uint16_t divider)
{
    uint16_t most = (uint16_t)(STREAM_WAYPOINTS * divider);
    uint16_t edges = edges_in(lead_ticks);

    return edges < most ? edges : most;
}

APART void reference_apply_settings(void)
{
    const struct settings *settings = settings_now();
    struct lock_grid *grid = lock_grid_now();

    BY_POINTER(grid);
    BY_POINTER(settings);
    uint8_t sync = (uint8_t)settings->sync;
    (void)settings_period(&clock_period, 1);
    (void)settings_period(&grid->pixel, settings->divider);
    grid->locks = sync == SYNC_LOCK;
    grid->ignored = sync == SYNC_FREE;
    grid->divider = settings->divider;
    lock_grid_tolerate(clock_period.whole_ticks /
                           divide_u32_u16(PPM, settings->lock_tolerance_ppm) +
                       1u);
    // A missing edge is bridged 3/8 of a period late: the time remains behind such an edge, too.
    grid->lead_edges =
        edges_ahead(LEAD_TICKS + clock_period.whole_ticks / 2u, grid->divider);
#if SEVERAL_AXES
    fast = clock_period.whole_ticks <= FAST_TICKS;
    grid->more_edges = grid->lead_edges;
    grid->lead_edges = edges_ahead(LEAD_TICKS, grid->divider);
    grid->more_edges = (uint16_t)(grid->more_edges - grid->lead_edges);
#endif
    place_edges = (uint8_t)edges_in(PLACE_TICKS);
    grid->filter.hold_over = (uint8_t)settings->hold_over_edges;
}

void reference_measure_anew(void)
{
    struct lock_grid *grid = lock_grid_now();
    uint16_t ahead_edges = (uint16_t)(grid->divider + grid->lead_edges);

#if SEVERAL_AXES
    ahead_edges = (uint16_t)(ahead_edges + grid->more_edges);
#endif
    clock_filter_aim(&grid->filter, clock_period.whole_ticks, ahead_edges);
#if FEATURE_CLOCK_STATISTICS
    edge_watch.divider = grid->divider;
#endif
    lock_grid_follow_from_here();
    reference_rest();
}

const struct pixel_period *reference_pixel(void)
{
    return &lock_grid_now()->pixel;
}

const struct pixel_period *reference_period(void)
{
    return &clock_period;
}

const struct clock_watch *reference_watch(void)
{
    return &edge_watch;
}

#if FEATURE_CLOCK_STATISTICS
// The clock's edge against its prediction, in the place of a plan.
static bool edge_of_grid(uint16_t *pixel)
{
    bool passes = lock_grid_passes(pixel);

    clock_watch_note(&edge_watch, lock_grid_now()->filter.error_ticks);
    return passes;
}

static inline bool edge_of_pixel(bool locks, uint32_t edge_ticks, uint16_t *pixel)
{
    return locks ? edge_of_grid(pixel)
                 : clock_watch_edge(&edge_watch, &clock_period, edge_ticks, pixel);
}
#else
static inline bool edge_of_pixel(bool locks, uint32_t edge_ticks, uint16_t *pixel)
{
    (void)locks;
    (void)edge_ticks;
    (void)pixel;
    return false;
}
#endif

bool reference_present(void)
{
    return edge_watch.known;
}

// A board at rest has the time for all of them.
#if SEVERAL_AXES
static inline bool too_many(void)
{
    return (fast || pixel_clock_waiting()) && axes_any_running();
}
#else
static inline bool too_many(void)
{
    if (pixel_clock_waiting()) {
        return true;
    }
    return place_edges >= FAST_EDGES && axes_get(0)->life.state == AXIS_RUNNING;
}
#endif

// Restart the time-out. A round later is soon enough but for a lock, which bridges a missing edge.
static inline void restart_time_out(bool locks)
{
    if (locks) {
        reference_await_edge();
    } else {
        edge_came = true;
    }
}

// The clock's period by one more edge. Edges that come as fast as they are taken are not measured
// where no line needs that. Returns false when it is a glitch.
static inline bool measure(bool locks, uint32_t edge_ticks)
{
    struct clock_filter *filter = &lock_grid_now()->filter;

    if (locks || !too_many()) {
        return clock_filter_edge(filter, edge_ticks);
    }
    clock_filter_restart(filter);
    return true;
}

enum edge_kind reference_edge(uint32_t edge_ticks, uint16_t *pixel)
{
    const struct lock_grid *grid = lock_grid_now();

    // False edges, too: they are what a clock of a wrong frequency is made of.
    if (grid->locks || !FEATURE_CLOCK_STATISTICS) {
        clock_watch_interval(&edge_watch, clock_period.whole_ticks, edge_ticks);
    }
    if (!measure(grid->locks, edge_ticks) && grid->locks) {
        return EDGE_FALSE;
    }
    restart_time_out(grid->locks);
    return edge_of_pixel(grid->locks, edge_ticks, pixel) ? EDGE_OF_PIXEL : EDGE_COUNTED;
}

uint16_t reference_number(void)
{
    const struct lock_grid *grid = lock_grid_now();

    return grid->locks ? grid->filter.edge : (uint16_t)edge_watch.edges;
}

uint8_t reference_place_edges(void)
{
    return place_edges;
}

void reference_count_lost(uint8_t edges)
{
    edge_watch.edges += edges;
}

bool reference_settled(void)
{
    return clock_filter_settled(&lock_grid_now()->filter);
}

void reference_edge_dropped(void)
{
    struct lock_grid *grid = lock_grid_now();

    reference_await_edge();
    // Locked lines go on by the predicted edge.
    if (grid->locks && clock_filter_bridge(&grid->filter)) {
        return;
    }
    edge_watch.edges++;
    clock_watch_forget(&edge_watch);
}

void reference_follow(uint32_t zero_ticks)
{
    clock_watch_follow(&edge_watch, &clock_period, zero_ticks);
    // The grid of a locked line has its own plan.
    edge_watch.following = !lock_grid_now()->locks;
}

void reference_rest(void)
{
    clock_watch_rest(&edge_watch);
    clock_filter_rest(&lock_grid_now()->filter);
}

void reference_await_edge(void)
{
    edge_seen_units = clock_now_units();
}

// Every round calls this function, so that it must be quick: shifts by whole bytes and a small
// factor. A lock takes no edge that is more than a quarter of a period late, and the pixel that
// waits for this edge must be decoded before the next one.
bool reference_overdue(void)
{
    const struct lock_grid *grid = lock_grid_now();
    uint16_t eighths = 12;

    if (edge_came) {
        edge_came = false;
        reference_await_edge();
        return false;
    }
    if (grid->locks) {
        eighths = (uint16_t)(11u + 8u * grid->filter.bridged);
    }
    return clock_now_units() - edge_seen_units >
           (uint32_t)(uint16_t)(clock_period.whole_ticks / 512u) * eighths + 7u;
}
