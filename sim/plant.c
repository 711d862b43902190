// SPDX-License-Identifier: MIT

#include "plant.h"

#include <string.h>

const char *plant_switch_name(enum plant_switch which)
{
    static const char *const names[PLANT_SWITCHES] = {"home", "minus", "plus"};

    return names[which];
}

bool plant_has(const struct plant *p, enum plant_switch which)
{
    return (which == PLANT_HOME) ? p->settings.has_home : p->settings.has_travel;
}

// Whether the load presses a switch. Because of its hysteresis, home depends on its state so far.
static bool is_pressed(const struct plant *p, enum plant_switch which)
{
    const struct plant_settings *s = &p->settings;

    if (!plant_has(p, which)) {
        return false;
    }
    switch (which) {
    case PLANT_LIMIT_MINUS:
        return p->load <= s->travel_min;
    case PLANT_LIMIT_PLUS:
        return p->load >= s->travel_max;
    case PLANT_HOME:
    case PLANT_SWITCHES:
    default:
        return p->pressed_home ? p->load > s->home - s->home_hysteresis
                               : p->load >= s->home;
    }
}

static bool update_switches(struct plant *p)
{
    bool changed = false;

    p->pressed_home = is_pressed(p, PLANT_HOME);
    for (unsigned i = 0; i < PLANT_SWITCHES; i++) {
        enum plant_stuck stuck = p->settings.stuck[i];
        bool closed =
            (i == PLANT_HOME) ? p->pressed_home : is_pressed(p, (enum plant_switch)i);

        closed = (stuck == STUCK_FREE) ? closed : stuck == STUCK_CLOSED;
        changed |= p->closed[i] != closed;
        p->closed[i] = closed;
    }
    return changed;
}

static void put_at_start(struct plant *p)
{
    p->load = p->settings.start;
    p->motor = p->load - (p->settings.taken_up_minus ? p->settings.play : 0);
    p->pressed_home = false; // within its hysteresis, home begins open
}

void plant_init(struct plant *p, const struct plant_settings *settings)
{
    memset(p, 0, sizeof *p);
    p->settings = *settings;
    put_at_start(p);
    (void)update_switches(p);
}

void plant_change(struct plant *p, const struct plant_settings *settings)
{
    p->settings = *settings;
    if (settings->has_start) {
        put_at_start(p);
    }
    (void)update_switches(p);
}

static bool at_hard_stop(const struct plant *p, int direction)
{
    const struct plant_settings *s = &p->settings;

    if (!s->has_travel) {
        return false;
    }
    return (direction > 0) ? p->load >= s->travel_max + s->over
                           : p->load <= s->travel_min - s->over;
}

// The load sits within the play around the motor. The motor pushes it up when the gap is 0, and
// pulls it down when the gap is as large as the play.
bool plant_step(struct plant *p, int direction)
{
    int64_t gap = p->motor - p->load; // 0 while pushing up, -play while pulling down
    bool pushes = (direction > 0) ? gap >= 0 : gap <= -p->settings.play;

    if (pushes && at_hard_stop(p, direction)) {
        p->lost_steps++;
        return false;
    }
    p->motor += direction;
    if (pushes) {
        p->load += direction;
        return update_switches(p);
    }
    return false;
}
