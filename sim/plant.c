// SPDX-License-Identifier: MIT
// This file is MIT; the program it is linked into is GPL-3.0 as a whole, because of libsimavr.

#include "plant.h"

#include <stdlib.h>
#include <string.h>

#define DEFAULT_OVER       100
#define DEFAULT_HYSTERESIS 8

static bool set_switch(struct plant *p, enum plant_switch which, bool closed)
{
    bool changed = p->closed[which] != closed;

    p->closed[which] = closed;
    return changed;
}

static bool update_switches(struct plant *p)
{
    const struct plant_settings *s = &p->settings;
    bool changed = false;

    if (s->has_home) {
        int64_t edge = p->closed[PLANT_HOME] ? s->home - s->home_hysteresis : s->home;
        bool closed = p->closed[PLANT_HOME] ? p->load > edge : p->load >= edge;

        changed = set_switch(p, PLANT_HOME, closed);
    }
    if (s->has_travel) {
        changed |= set_switch(p, PLANT_LIMIT_MINUS, p->load <= s->travel_min);
        changed |= set_switch(p, PLANT_LIMIT_PLUS, p->load >= s->travel_max);
    }
    return changed;
}

void plant_init(struct plant *p, const struct plant_settings *settings)
{
    memset(p, 0, sizeof *p);
    p->settings = *settings;
    p->motor = p->load = settings->start;
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

// The load sits within the play behind the motor: pushed up at its lower end, pulled down at its
// upper. Starting point: play taken up in the positive direction.
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

static bool number(const char *text, int64_t *value)
{
    char *end;

    *value = strtoll(text, &end, 10);
    return end != text && *end == '\0';
}

static bool range(char *text, int64_t *low, int64_t *high)
{
    char *dots = strstr(text, "..");

    if (dots == NULL) {
        return false;
    }
    *dots = '\0';
    return number(text, low) && number(dots + 2, high) && *low < *high;
}

static bool not_negative(const char *text, int64_t *value)
{
    return number(text, value) && *value >= 0;
}

static bool switch_knob(struct plant_settings *s, const char *name, char *value)
{
    if (strcmp(name, "travel") == 0) {
        s->has_travel = true;
        return range(value, &s->travel_min, &s->travel_max);
    }
    if (strcmp(name, "home") == 0) {
        s->has_home = true;
        return number(value, &s->home);
    }
    if (strcmp(name, "active") == 0) {
        s->active_high = strcmp(value, "high") == 0;
        return s->active_high || strcmp(value, "low") == 0;
    }
    return false;
}

static bool knob(struct plant_settings *s, const char *name, char *value)
{
    if (strcmp(name, "play") == 0) {
        return not_negative(value, &s->play);
    }
    if (strcmp(name, "over") == 0) {
        return not_negative(value, &s->over);
    }
    if (strcmp(name, "hyst") == 0) {
        return not_negative(value, &s->home_hysteresis);
    }
    if (strcmp(name, "start") == 0) {
        return number(value, &s->start);
    }
    return switch_knob(s, name, value);
}

const char *plant_parse(struct plant_settings *s, char *text)
{
    char *rest = text;
    char *word;

    s->present = true;
    s->over = DEFAULT_OVER;
    s->home_hysteresis = DEFAULT_HYSTERESIS;
    while ((word = strsep(&rest, ",")) != NULL) {
        char *equals = strchr(word, '=');

        if (equals == NULL) {
            return word;
        }
        *equals = '\0';
        if (!knob(s, word, equals + 1)) {
            return word;
        }
    }
    return NULL;
}
