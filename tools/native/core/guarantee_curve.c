// SPDX-License-Identifier: MIT
#include "guarantee_pixel.h"

#include <math.h>

// Limits of the firmware: curve.c, curve_flat.c, curve_steep.c.
#define INTERVAL_MAX 64256.0 // of flat steps
#define NARROW_LIMIT 7.0e8   // of speed * ticks, where 32 bits are enough
#define NARROW_SPEED 2800.0
#define WIDE_LIMIT   1.8e11
#define STEEP_LIMIT  9.0e10
#define QUICK_TICKS  32767.0
#define START_CHANGE 255.0
#define MISS_TICKS   16.0
#define FIRST_STEPS  3.0 // found by Newton's method where nothing foretells them
#define NEVER        1e300

enum flat { NOT_FLAT, NARROW, WIDE };

// Which steps are flat: those at `from` steps a pixel and more.
struct flat_part {
    enum flat kind;
    double from;
    bool stays;
};

static double steps_until(const struct curve_shape *c, double speed)
{
    return (speed * speed - c->speed * c->speed) / (4.0 * c->half);
}

static double speed_at(const struct curve_shape *c, double k)
{
    return sqrt(fmax(0.0, c->speed * c->speed + 4.0 * c->half * k));
}

// Steps of k0..k1 at speeds from `low` on and below `high`.
static double between(
    const struct curve_shape *c, double k0, double k1, double low, double high)
{
    double a = steps_until(c, c->half > 0.0 ? low : high);
    double b = steps_until(c, c->half > 0.0 ? high : low);

    return fmax(0.0, fmin(b, k1) - fmax(a, k0));
}

static enum flat flat_kind(double ticks, double top, bool loose)
{
    double share = loose ? 0.5 : 1.0;

    if (top * ticks >= WIDE_LIMIT * share) {
        return NOT_FLAT;
    }
    return top * ticks < NARROW_LIMIT * share && top <= NARROW_SPEED * share ? NARROW
                                                                             : WIDE;
}

// Where the interval changes by less than four ticks from step to step the curve begins flat; one
// that slows down is steep from two ticks on, one that speeds up until it has come below three.
static struct flat_part flat_part(const struct curve_shape *c)
{
    double h_ticks = fabs(c->half) * c->ticks;
    double last = speed_at(c, c->steps);
    double top = fmax(c->speed, last);
    double low = fmin(c->speed, last);
    double most = c->half > 0.0 ? 1.5 : 1.0;

    if (h_ticks / 2.0 < low * low * low && c->ticks <= INTERVAL_MAX * low) {
        bool loose = 2.0 * h_ticks >= low * low * low;
        return (struct flat_part){flat_kind(c->ticks, top, loose), 0.0, true};
    }
    if (c->half < 0.0 &&
        (h_ticks / 2.0 >= top * top * top || c->ticks > INTERVAL_MAX * top)) {
        return (struct flat_part){NOT_FLAT, NEVER, false};
    }
    double from = fmax(cbrt(h_ticks / most), c->ticks / QUICK_TICKS);
    return (struct flat_part){flat_kind(c->ticks, top, true), from, c->half > 0.0};
}

// The first steps of a piece are found by Newton's method where its speed does not foretell them.
static bool foretold(const struct curve_shape *c)
{
    double interval = c->ticks / fmax(c->speed, 1.0);
    double change = interval * fabs(c->half) / fmax(c->speed * c->speed, 1.0);

    return c->speed > c->ticks / 65536.0 && interval <= QUICK_TICKS - START_CHANGE &&
           change <= START_CHANGE && change * change <= interval;
}

static double clamp(double value, double low, double high)
{
    return fmin(fmax(value, low), high);
}

static void count_flat(const struct curve_shape *c,
                       const struct flat_part *flat,
                       double k0,
                       double k1,
                       struct steps_found *found)
{
    double steps = between(c, k0, k1, flat->from, NEVER);
    double a = fmax(speed_at(c, k0), fmax(flat->from, 1.0));
    double b = fmax(speed_at(c, k1), fmax(flat->from, 1.0));
    double moved = fabs(c->ticks / a - c->ticks / b);

    if (steps <= 0.0) {
        return;
    }
    if (flat->kind == NARROW) {
        found->flat += steps;
        found->moved += moved;
    } else {
        found->wide += steps;
        found->wide_moved += moved;
    }
    if (!flat->stays) {
        // While the change is above an eighth of a tick, as many steps as the interval has
        // sixteens of ticks.
        double until = cbrt(16.0 * fabs(c->half) * c->ticks);
        double few = between(c, k0, k1, flat->from, until);
        double interval = 2.0 * c->ticks / (fmin(a, until) + fmin(b, until));
        found->batches += few / fmin(interval / 16.0 + 1.0, BATCH);
    }
}

void guarantee_curve(const struct curve_shape *curve,
                     double k0,
                     double k1,
                     struct steps_found *found)
{
    double h = fabs(curve->half);
    struct flat_part flat = {NOT_FLAT, NEVER, false};

    if (!curve->whole) {
        flat = flat_part(curve);
    }
    if (flat.kind == NOT_FLAT) {
        flat.from = NEVER;
    }
    double slow_below = fmin(fmax(pow(12.0 / MISS_TICKS * h * h * curve->ticks, 0.2),
                                  curve->ticks / QUICK_TICKS),
                             flat.from);
    double steep_below = fmax(slow_below, fmin(flat.from, STEEP_LIMIT / curve->ticks));
    double slow = k1 - k0 - between(curve, k0, k1, slow_below, steep_below) -
                  between(curve, k0, k1, flat.from, NEVER);
    if (k0 <= 0.0 && !curve->goes_on && curve->speed < flat.from && !foretold(curve)) {
        slow = fmax(slow, fmin(k1, FIRST_STEPS));
    }
    count_flat(curve, &flat, k0, k1, found);
    double steep = k1 - k0 - slow - between(curve, k0, k1, flat.from, NEVER);
    if (steep > 0.0) {
        double a = clamp(speed_at(curve, k0), fmax(slow_below, 1.0), steep_below);
        double b = clamp(speed_at(curve, k1), fmax(slow_below, 1.0), steep_below);
        found->steep += steep;
        found->missed +=
            fabs(2.0 * h * curve->ticks * (1.0 / (a * a * a) - 1.0 / (b * b * b)));
    }
    found->slow += fmax(0.0, slow);
}

bool guarantee_curve_steep(const struct curve_shape *curve, double k)
{
    struct flat_part flat = flat_part(curve);

    return flat.kind == NOT_FLAT || speed_at(curve, k) < flat.from;
}
