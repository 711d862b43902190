// SPDX-License-Identifier: MIT
// pixstep-explore: tries every placement of hardware events over sequences of commands.
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "config.h" // CONFIG_AXES
#include "explore/board.h"
#include "explore/search.h"

static int misuse(void)
{
    (void)fputs(
        "usage: pixstep-explore [--actions N] [--periods N] [--pins N] [--from "
        "SCENARIO]\n"
        "                       [--every N] [--first]\n"
        "  N actions in a sequence, N ends of periods and N changes of the emergency\n"
        "  stop's pin placed in it; --every: each N-th situation; --first: only up to "
        "the\n"
        "  first rule that is broken\n",
        stderr);
    return 2;
}

static void add(struct search_counts *sum, const struct search_counts *counts)
{
    sum->sequences += counts->sequences;
    sum->schedules += counts->schedules;
    sum->runs += counts->runs;
    sum->states += counts->states;
    sum->judged += counts->judged;
    if (counts->points > sum->points) {
        sum->points = counts->points;
    }
}

static void print(const char *name, const struct search_counts *counts)
{
    (void)printf("%-34s %9.0f %14.0f %11llu %9llu %9llu %5u\n",
                 name,
                 counts->sequences,
                 counts->schedules,
                 (unsigned long long)counts->runs,
                 (unsigned long long)counts->states,
                 (unsigned long long)counts->judged,
                 counts->points);
    (void)fflush(stdout);
}

static bool take_number(const char *text, uint8_t most, uint8_t *number)
{
    char *end = NULL;
    unsigned long value = strtoul(text, &end, 10);

    *number = (uint8_t)value;
    return *text != '\0' && *end == '\0' && value <= most;
}

struct options {
    struct search_limits limits; // none: the limits that the tests use
    uint16_t first, last;        // scenario
    uint16_t every;              // of these scenarios, each so many
    bool to_the_first;           // end at the first way that breaks a rule
};

// What the long tests search: tens of seconds of one axis, some minutes of two.
struct usual {
    struct search_limits limits;
    uint16_t every; // of the situations
};

static const struct usual usual[] = {
#if CONFIG_AXES > 1
    {{.actions = 1, .periods = 1, .pins = 0}, 1},
    {{.actions = 1, .periods = 2, .pins = 0}, 1},
    {{.actions = 2, .periods = 1, .pins = 0}, 4},
    {{.actions = 1, .periods = 1, .pins = 1}, 8},
#else
    {{.actions = 3, .periods = 1, .pins = 0}, 1},
    {{.actions = 2, .periods = 1, .pins = 1}, 1},
    {{.actions = 1, .periods = 2, .pins = 1}, 1},
#endif
};

static bool take_option(const char *name, const char *value, struct options *options)
{
    if (strcmp(name, "--actions") == 0) {
        return take_number(value, 5, &options->limits.actions);
    }
    if (strcmp(name, "--periods") == 0) {
        return take_number(value, 4, &options->limits.periods);
    }
    if (strcmp(name, "--pins") == 0) {
        return take_number(value, 4, &options->limits.pins);
    }
    if (strcmp(name, "--every") == 0) {
        uint8_t every = 0;
        bool taken = take_number(value, UINT8_MAX, &every);
        options->every = every;
        return taken && every != 0;
    }
    if (strcmp(name, "--from") != 0) {
        return false;
    }
    options->first = 0;
    while (options->first <= options->last &&
           strcmp(board_scenario(options->first), value) != 0) {
        options->first++;
    }
    bool found = options->first <= options->last;
    options->last = options->first;
    return found;
}

static bool take_options(int count, char **words, struct options *options)
{
    for (int i = 1; i < count; i++) {
        if (strcmp(words[i], "--first") == 0) {
            options->to_the_first = true;
        } else if (i + 1 == count || !take_option(words[i], words[i + 1], options)) {
            return false;
        } else {
            i++;
        }
    }
    return true;
}

static void print_heading(void)
{
    (void)printf("%-34s %9s %14s %11s %9s %9s %6s\n",
                 "from",
                 "sequences",
                 "schedules",
                 "runs",
                 "states",
                 "judged",
                 "points");
}

static bool explore(const struct options *options, const struct search_limits *limits)
{
    struct search_counts sum = {0};
    bool fine = true;

    (void)printf("sequences of up to %u, %u ends of periods, %u changes of the pin\n",
                 limits->actions,
                 limits->periods,
                 limits->pins);
    print_heading();
    for (uint16_t i = options->first; i <= options->last;
         i = (uint16_t)(i + options->every)) {
        struct search_counts counts;
        fine = search_scenario(i, limits, &counts, stdout) && fine;
        if (!fine && options->to_the_first) {
            return false;
        }
        print(board_scenario(i), &counts);
        add(&sum, &counts);
    }
    print("together", &sum);
    return fine;
}

int main(int argc, char **argv)
{
    struct options options = {.last = (uint16_t)(board_scenarios() - 1u), .every = 1};
    bool fine = true;

    if (!take_options(argc, argv, &options)) {
        return misuse();
    }
    if (options.limits.actions != 0) {
        return explore(&options, &options.limits) ? 0 : 1;
    }
    for (size_t i = 0; i < sizeof usual / sizeof usual[0]; i++) {
        options.every = usual[i].every;
        fine = explore(&options, &usual[i].limits) && fine;
        if (!fine && options.to_the_first) {
            break;
        }
    }
    return fine ? 0 : 1;
}
