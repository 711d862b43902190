// SPDX-License-Identifier: MIT
#include <stdlib.h>

#include "core.h"

// Take away the limit that an error is about. The check keeps the highest speed of its line, which
// it is given back behind the entry. Returns false for an error that is about no limit.
static bool lift_limit(struct line_check *check,
                       struct line_limits *limits,
                       enum line_error error)
{
    if (error == LINE_too_fast) {
        check->top_speed = UINT16_MAX;
    } else if (error == LINE_acceleration) {
        limits->max_acceleration = 0;
    } else if (error == LINE_reversal_too_fast) {
        limits->reversal_min_ticks = 0;
    } else if (error == LINE_reversal_without_ramp) {
        limits->start_stop_steps = 0;
    } else {
        return false;
    }
    return true;
}

struct report {
    struct core_finding *found;
    uint32_t count;
    uint32_t room;
};

static void note(struct report *report, uint32_t code, uint32_t pixel)
{
    if (code != LINE_none && report->count < report->room) {
        report->found[report->count++] =
            (struct core_finding){.code = code, .pixel = pixel};
    }
}

// Check one entry. Every error is noted, and as long as it leaves a way on, the entry is checked
// again without what it violates. Returns false when the check ends.
static bool check_entry(struct line_check *check,
                        const struct line_limits *limits,
                        struct segment entry,
                        struct report *report)
{
    struct line_check before = *check;
    uint16_t top_speed = check->top_speed;
    struct line_limits kept = *limits;
    uint32_t rest_px = 0; // pixels that the entry stands for without being checked
    enum line_error error;

    if (check->phase == LINE_CHECK_DIVIDER && entry.repeat == 0 &&
        !divider_possible((uint16_t)entry.count)) {
        note(report, LINE_divider, before.pixel + 1u);
        return false;
    }
    while ((error = line_check_entry(check, &kept, entry)) != LINE_none) {
        note(report, error, before.pixel + 1u);
        if (error == LINE_oscillates) {
            // A single pixel after another count never oscillates.
            rest_px = entry.repeat - 1u;
            entry.repeat = 1;
            before.last_count = (int16_t)~entry.count;
        } else if (!lift_limit(&before, &kept, error)) {
            return false;
        }
        *check = before;
    }
    if (before.top_speed != top_speed) {
        check->top_speed = top_speed;
        check->easy_speed = 0;
    }
    if ((rest_px & 1u) != 0) {
        check->speed = before.speed;
    }
    // The check keeps the first warning of a line; each of them is wanted here.
    note(report, check->warning, before.pixel + 1u);
    check->warning = LINE_none;
    check->pixel += rest_px;
    return true;
}

struct checker {
    struct line_limits limits;
    struct line_check check;
    bool ended;
};

struct checker *checker_begin(const struct line_limits *limits)
{
    struct checker *checker = malloc(sizeof *checker);

    if (checker != NULL) {
        checker->limits = *limits;
        checker->ended = false;
        line_check_reset(&checker->check);
    }
    return checker;
}

uint32_t checker_more(struct checker *checker,
                      const struct segment *entries,
                      uint32_t entry_count,
                      struct core_finding *found,
                      uint32_t room)
{
    struct report report = {.found = found, .room = room};

    for (uint32_t i = 0; i < entry_count && !checker->ended; i++) {
        checker->ended =
            !check_entry(&checker->check, &checker->limits, entries[i], &report);
    }
    return report.count;
}

void checker_end(struct checker *checker)
{
    free(checker);
}
