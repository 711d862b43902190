// SPDX-License-Identifier: MIT
#include "explore/report.h"

#include "explore/board.h"
#include "explore/program.h"

static const char *const event_names[PART_EVENT_KINDS] = {
    [PART_PERIOD_ENDS] = "a period ends",
    [PART_PIN_CHANGES] = "the emergency stop's pin changes",
};

void report_begin(FILE *report, uint16_t scenario)
{
    (void)fprintf(
        report, "broken: %s\nfrom \"%s\":\n", program_broken(), board_scenario(scenario));
}

// Report one step. Events are written before the piece in which they happen.
static void report_step(FILE *report, const struct step *step)
{
    for (unsigned event = 0; event < PART_EVENT_KINDS; event++) {
        if ((step->events & 1u << event) != 0) {
            (void)fprintf(report,
                          "    at its point %u (%p): %s\n",
                          step->point,
                          step->pc,
                          event_names[event]);
        }
    }
    if (step->piece == PROGRAM_ROUND) {
        (void)fputs("  a round of the main loop\n", report);
    } else if (step->piece != STEP_NO_PIECE) {
        (void)fprintf(report, "  %s\n", board_action(step->piece));
    }
}

void report_way(FILE *report, const struct steps *steps, uint32_t last)
{
    // The steps are linked from the end to the beginning. A way has only a few steps, so that each
    // step is found by walking from the end.
    for (uint32_t shown = STEP_FIRST; last != shown;) {
        uint32_t first = last;
        while (steps->steps[first].parent != shown) {
            first = steps->steps[first].parent;
        }
        report_step(report, &steps->steps[first]);
        shown = first;
    }
}

void report_last(FILE *report, const struct step *last)
{
    if (last == NULL) {
        (void)fputs("  then idle periods\n", report);
    } else {
        report_step(report, last);
    }
}
