// SPDX-License-Identifier: MIT
#include "explore/judge.h"

#include "explore/board.h"
#include "explore/part.h"

struct judged judged;

static void allow_at_most(uint8_t edges)
{
    if (judged.edges_allowed > edges) {
        judged.edges_allowed = edges;
    }
}

void judge_edge(bool negative)
{
    judged.position += negative ? -1 : 1;
    if (judged.edges_allowed == 0) {
        judge_broken(JUDGE_RUNAWAY);
    }
    if (judged.edges_allowed != JUDGE_ANY_NUMBER) {
        judged.edges_allowed--;
    } else if (board_held()) {
        judge_broken(JUDGE_EARLY);
    }
}

void judge_look(void)
{
    if (board_stopped()) {
        judged.permit_given = false;
    }
    // What the timer holds still comes.
    if (board_halted()) {
        allow_at_most(1);
    }
    if (part_permit_high() && !judged.permit_given) {
        judge_broken(JUDGE_PERMIT);
    }
}

// An AVR accesses words in two halves. Shared ones must be accessed with interrupts off; excused
// are those of which the reader takes the low byte only, or that the protocol of the runs keeps
// apart.
void judge_access(const volatile void *address, uint32_t bytes)
{
    if (bytes > 1 && part.interrupts_on && !board_excused(address)) {
        judge_broken(JUDGE_WIDE);
    }
}

void judge_between(void)
{
    if (board_finished()) {
        allow_at_most(0);
    } else if (!board_moving() || board_stopped()) {
        allow_at_most(1);
    }
    if (board_promise_broken()) {
        judge_broken(JUDGE_PROMISE);
    }
}
