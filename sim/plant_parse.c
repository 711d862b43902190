// SPDX-License-Identifier: MIT

#include "plant_parse.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define DEFAULT_OVER       100
#define DEFAULT_HYSTERESIS 8
#define TICKS_MOST         16000000U // a second, or nearly

static bool read_number(const char *text, int64_t *value)
{
    char *end;

    errno = 0;
    *value = strtoll(text, &end, 10);
    return end != text && *end == '\0' && errno == 0;
}

static bool read_range(char *text, int64_t *low, int64_t *high)
{
    char *dots = strstr(text, "..");

    if (dots == NULL) {
        return false;
    }
    *dots = '\0';
    return read_number(text, low) && read_number(dots + 2, high) && *low < *high;
}

static bool read_not_negative(const char *text, int64_t *value)
{
    return read_number(text, value) && *value >= 0;
}

static bool read_at_most(const char *text, uint32_t most, uint32_t *value)
{
    int64_t wide;

    if (!read_not_negative(text, &wide) || wide > (int64_t)most) {
        return false;
    }
    *value = (uint32_t)wide;
    return true;
}

static bool read_play(struct plant_settings *s, char *value)
{
    return read_not_negative(value, &s->play);
}

static bool read_travel(struct plant_settings *s, char *value)
{
    s->has_travel = true;
    return read_range(value, &s->travel_min, &s->travel_max);
}

static bool read_over(struct plant_settings *s, char *value)
{
    return read_not_negative(value, &s->over);
}

static bool read_home(struct plant_settings *s, char *value)
{
    s->has_home = true;
    return read_number(value, &s->home);
}

static bool read_hysteresis(struct plant_settings *s, char *value)
{
    return read_not_negative(value, &s->home_hysteresis);
}

static bool read_start(struct plant_settings *s, char *value)
{
    s->has_start = true;
    return read_number(value, &s->start);
}

static bool read_taken_up(struct plant_settings *s, char *value)
{
    s->taken_up_minus = strcmp(value, "minus") == 0;
    return s->taken_up_minus || strcmp(value, "plus") == 0;
}

static bool read_active(struct plant_settings *s, char *value)
{
    s->active_high = strcmp(value, "high") == 0;
    return s->active_high || strcmp(value, "low") == 0;
}

static bool read_delay(struct plant_settings *s, char *value)
{
    return read_at_most(value, TICKS_MOST, &s->contact.delay_ticks);
}

static bool read_bounce(struct plant_settings *s, char *value)
{
    return read_at_most(value, CONTACT_BOUNCE_MOST, &s->contact.bounce) &&
           s->contact.bounce % 2 == 0;
}

static bool read_bounce_ticks(struct plant_settings *s, char *value)
{
    return read_at_most(value, TICKS_MOST, &s->contact.bounce_ticks);
}

static bool read_seed(struct plant_settings *s, char *value)
{
    int64_t wide;

    s->has_seed = true;
    if (!read_not_negative(value, &wide)) {
        return false;
    }
    s->seed = (uint64_t)wide;
    return true;
}

// The index of a word in a list, or `count`.
static unsigned find_word(const char *word, const char *const list[], unsigned count)
{
    unsigned i = 0;

    while (i < count && strcmp(word, list[i]) != 0) {
        i++;
    }
    return i;
}

static bool read_stuck_switch(struct plant_settings *s, char *word)
{
    static const char *const states[] = {"free", "open", "closed"};
    char *colon = strchr(word, ':');
    unsigned which = 0;
    unsigned state;

    if (colon == NULL) {
        return false;
    }
    *colon = '\0';
    while (which < PLANT_SWITCHES &&
           strcmp(word, plant_switch_name((enum plant_switch)which)) != 0) {
        which++;
    }
    state = find_word(colon + 1, states, STUCK_CLOSED + 1U);
    *colon = ':';
    if (which == PLANT_SWITCHES || state > STUCK_CLOSED) {
        return false;
    }
    s->stuck[which] = (enum plant_stuck)state;
    return true;
}

// "home:closed+plus:open", or "none".
static bool read_stuck(struct plant_settings *s, char *value)
{
    char *rest = value;
    char *word;

    if (strcmp(value, "none") == 0) {
        memset(s->stuck, 0, sizeof s->stuck);
        return true;
    }
    while ((word = strsep(&rest, "+")) != NULL) {
        if (!read_stuck_switch(s, word)) {
            return false;
        }
    }
    return true;
}

static const struct {
    const char *name;
    bool (*read)(struct plant_settings *s, char *value);
    const char *expected;
} parameters[] = {
    {"play", read_play, "steps, 0 or more"},
    {"travel", read_travel, "FIRST..LAST in steps"},
    {"over", read_over, "steps, 0 or more"},
    {"home", read_home, "a position in steps"},
    {"hyst", read_hysteresis, "steps, 0 or more"},
    {"start", read_start, "a position in steps"},
    {"taken_up", read_taken_up, "plus or minus"},
    {"active", read_active, "low or high"},
    {"delay", read_delay, "ticks, 0 to 16000000"},
    {"bounce", read_bounce, "an even number of edges, 0 to 64"},
    {"bounce_ticks", read_bounce_ticks, "ticks, 0 to 16000000"},
    {"seed", read_seed, "a whole number, 0 or more"},
    {"stuck",
     read_stuck,
     "none, or home, minus, plus with :closed, :open, :free, joined by +"},
};
#define PARAMETERS (sizeof parameters / sizeof parameters[0])

static bool read_parameter(struct plant_settings *s, char *word, char *error, size_t size)
{
    char *equals = strchr(word, '=');
    char value[64];
    size_t i = 0;

    if (equals == NULL) {
        (void)snprintf(error, size, "cannot make sense of '%s'", word);
        return false;
    }
    *equals = '\0';
    (void)snprintf(value, sizeof value, "%s", equals + 1); // reading cuts the word up
    while (i < PARAMETERS && strcmp(word, parameters[i].name) != 0) {
        i++;
    }
    if (i == PARAMETERS) {
        (void)snprintf(error, size, "there is no parameter '%s'", word);
        return false;
    }
    if (strlen(equals + 1) >= sizeof value || !parameters[i].read(s, equals + 1)) {
        (void)snprintf(
            error, size, "%s='%s': expected %s", word, value, parameters[i].expected);
        return false;
    }
    return true;
}

static void set_defaults(struct plant_settings *s)
{
    s->present = true;
    s->over = DEFAULT_OVER;
    s->home_hysteresis = DEFAULT_HYSTERESIS;
}

static bool is_consistent(const struct plant_settings *s, char *error, size_t size)
{
    bool limit_stuck = s->stuck[PLANT_LIMIT_MINUS] != STUCK_FREE ||
                       s->stuck[PLANT_LIMIT_PLUS] != STUCK_FREE;

    if (s->contact.bounce > s->contact.bounce_ticks) {
        (void)snprintf(error,
                       size,
                       "bounce=%u: bounce_ticks must be at least as many, not %u",
                       s->contact.bounce,
                       s->contact.bounce_ticks);
        return false;
    }
    if (s->stuck[PLANT_HOME] != STUCK_FREE && !s->has_home) {
        (void)snprintf(error, size, "stuck=home: there is no home switch (home=N)");
        return false;
    }
    if (limit_stuck && !s->has_travel) {
        (void)snprintf(
            error,
            size,
            "stuck=minus, plus: there are no limit switches (travel=MIN..MAX)");
        return false;
    }
    return true;
}

bool plant_parse(struct plant_settings *s, char *text, char *error, size_t error_size)
{
    char *rest = text;
    char *word;

    if (!s->present) {
        set_defaults(s);
    }
    while ((word = strsep(&rest, ",")) != NULL) {
        if (!read_parameter(s, word, error, error_size)) {
            return false;
        }
    }
    return is_consistent(s, error, error_size);
}
