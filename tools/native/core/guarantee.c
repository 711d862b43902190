// SPDX-License-Identifier: MIT
#include "guarantee.h"

#include <stdlib.h>

#include "guarantee_loop.h"

void guarantee_demand(const struct guarantee_costs *costs,
                      const struct guarantee_board *board,
                      const struct guarantee_axis *line,
                      double *decode,
                      double *account)
{
    struct walk walk;
    struct job job;

    walk_begin(&walk, line);
    *decode = 0.0;
    *account = 0.0;
    while (walk_piece(&walk, board)) {
        walk_job(&walk, costs, board, BATCH, &job);
        *decode += job.begin_cycles + job.cycles;
        *account += job.part.account;
        walk_pass(&walk, &job);
    }
}

void guarantee_judge(const struct guarantee_costs *costs,
                     const struct guarantee_board *board,
                     const struct guarantee_axis *line,
                     uint32_t lines,
                     struct guarantee_verdict *verdict)
{
    struct loop *loop = calloc(1, sizeof *loop);

    *verdict = (struct guarantee_verdict){.follows = true, .slack_ticks = NEVER_TICKS};
    if (loop == NULL) {
        verdict->follows = false;
        return;
    }
    loop->cost = costs;
    loop->board = board;
    loop->verdict = verdict;
    loop_begin(loop, line, lines);
    loop_play(loop);
    verdict->busy = loop->now > 0.0 ? loop->work / loop->now : 0.0;
    free(loop);
}
