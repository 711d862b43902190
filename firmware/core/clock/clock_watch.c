// SPDX-License-Identifier: MIT
#include "clock/clock_watch.h"

#include "base/apart.h" // APART

// Most missing edges in a row while a line is followed. With more of them the line must be over: a
// running line ends with a fault before (reference_overdue()).
#define MISSED_MAX 4u

// An interval in units of 256 ticks; never 0, which would stand for none.
static uint16_t shown_interval(uint32_t interval_ticks)
{
    return interval_ticks >> 24 != 0 ? UINT16_MAX
                                     : (uint16_t)(clock_watch_units(interval_ticks) | 1u);
}

void clock_watch_interval(struct clock_watch *watch,
                          uint32_t period_ticks,
                          uint32_t edge_ticks)
{
    BY_POINTER(watch);
    uint32_t interval_ticks = edge_ticks - watch->edge_ticks;
    uint32_t most_ticks = period_ticks / 16u;

    watch->odd =
        watch->known && interval_ticks - period_ticks + most_ticks > 2u * most_ticks
            ? shown_interval(interval_ticks)
            : 0;
    watch->edges++;
    watch->edge_ticks = edge_ticks;
    watch->known = true;
}

#if FEATURE_CLOCK_STATISTICS

// An error is at most so many times near_ticks for an edge to be near: nearly half a period.
#define NEAR_MOST 16u

// One tick less than a thirty-second: planned times are whole ticks. NEAR_MOST of them fit 15 bits.
static uint16_t near_of(const struct pixel_period *period)
{
    uint32_t near_ticks = period->whole_ticks / 32u - 1u;

    return near_ticks > INT16_MAX / 32u ? INT16_MAX / 32u : (uint16_t)near_ticks;
}

void clock_watch_follow(struct clock_watch *watch,
                        const struct pixel_period *period,
                        uint32_t zero_ticks)
{
    watch->following = true;
    watch->zero_ticks = zero_ticks;
    watch->next_ticks = zero_ticks;
    watch->pixel = 0;
    watch->phase = 0;
    watch->error_ticks = 0;
    watch->error_max_ticks = 0;
    watch->near = false;
    watch->near_ticks = near_of(period);
    pixel_grid_start(&watch->grid, period);
}

static int16_t saturate_int16(int32_t value)
{
    if (value > INT16_MAX) {
        return INT16_MAX;
    }
    return value < -INT16_MAX ? (int16_t)-INT16_MAX : (int16_t)value;
}

static APART_SMALL void plan_next(struct clock_watch *watch)
{
    watch->next_ticks += pixel_grid_advance(&watch->grid);
    watch->phase++;
    if (watch->phase >= watch->divider) {
        watch->phase = 0;
        watch->pixel++;
    }
}

static void note_error(struct clock_watch *watch, int16_t error_ticks)
{
    uint16_t size = (uint16_t)(error_ticks < 0 ? -error_ticks : error_ticks);

    watch->error_ticks = error_ticks;
    if (size > watch->error_max_ticks) {
        watch->error_max_ticks = size;
    }
}

void clock_watch_note(struct clock_watch *watch, int32_t error_ticks)
{
    note_error(watch, saturate_int16(error_ticks));
}

// Plan the edge behind the one that came. Returns true when that one is a pixel edge, *pixel.
static inline bool pass_planned(struct clock_watch *watch, uint16_t *pixel)
{
    bool pixel_edge = watch->phase == 0;

    *pixel = watch->pixel;
    plan_next(watch);
    return pixel_edge;
}

// The value is not below -most or above `most`, which is below 2^15.
static inline bool within(int32_t value, uint16_t most)
{
    uint32_t place = (uint32_t)value + most;

    return place >> 16 == 0 && (uint16_t)place <= (uint16_t)(2u * most);
}

// The edge came where it was planned, but for what the clock is off the plan since its last edge.
static inline bool is_near(const struct clock_watch *watch, int32_t error_ticks)
{
    uint16_t near_ticks = watch->near_ticks;

    return within(error_ticks - watch->error_ticks, near_ticks) &&
           within(error_ticks, (uint16_t)(NEAR_MOST * near_ticks));
}

// An edge that was not expected here, or the first one that was.
static APART bool look_closely(struct clock_watch *watch,
                               const struct pixel_period *period,
                               uint32_t edge_ticks,
                               uint16_t *pixel)
{
    uint8_t missed = 0;

    clock_watch_interval(watch, period->whole_ticks, edge_ticks);
    watch->near = false;
    if (!watch->following) {
        return false;
    }
    int32_t half_period = (int32_t)(period->whole_ticks / 2u);
    if ((int32_t)(edge_ticks - watch->next_ticks) < -half_period) {
        return false;
    }
    // Edges that never came are skipped, so that one gap does not shift all later edges.
    while ((int32_t)(edge_ticks - watch->next_ticks) > half_period) {
        if (missed == MISSED_MAX) {
            watch->following = false;
            return false;
        }
        missed++;
        plan_next(watch);
    }
    int32_t error_ticks = (int32_t)(edge_ticks - watch->next_ticks);
    watch->near =
        watch->odd == 0 && within(error_ticks, (uint16_t)(NEAR_MOST * watch->near_ticks));
    clock_watch_note(watch, error_ticks);
    return pass_planned(watch, pixel);
}

// Take an edge that is near its planned time. Returns false and changes nothing when it came
// elsewhere; else *of_pixel is the result of clock_watch_edge().
static inline bool take_near(struct clock_watch *watch,
                             uint32_t edge_ticks,
                             uint16_t *pixel,
                             bool *of_pixel)
{
    int32_t error_ticks = (int32_t)(edge_ticks - watch->next_ticks);

    if (!is_near(watch, error_ticks)) {
        return false;
    }
    // Its time is known, as that of the edge before it was, and the distance is not odd.
    watch->edges++;
    watch->edge_ticks = edge_ticks;
    note_error(watch, (int16_t)error_ticks);
    *of_pixel = pass_planned(watch, pixel);
    return true;
}

bool clock_watch_edge(struct clock_watch *watch,
                      const struct pixel_period *period,
                      uint32_t edge_ticks,
                      uint16_t *pixel)
{
    bool of_pixel = false;

    // Edge after edge where it was planned is all there is, nearly always.
    if (watch->following && watch->near &&
        take_near(watch, edge_ticks, pixel, &of_pixel)) {
        return of_pixel;
    }
    return look_closely(watch, period, edge_ticks, pixel);
}

#else

void clock_watch_follow(struct clock_watch *watch,
                        const struct pixel_period *period,
                        uint32_t zero_ticks)
{
    (void)period;
    (void)zero_ticks;
    watch->following = true;
}

#endif
