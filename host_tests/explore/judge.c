// SPDX-License-Identifier: MIT
#include "explore/judge.h"
#include "explore/judged.h"

#include "explore/board.h"
#include "explore/part.h"

#define IDLE_AT_REST 8u   // periods without an edge
#define REST_MAX     300u // periods until an axis rests

struct judged judged;

static void allow_at_most(uint8_t edges)
{
    if (judged.edges_allowed > edges) {
        judged.edges_allowed = edges;
    }
}

void judge_edge(uint8_t axis, uint32_t ticks, bool negative)
{
    (void)axis;
    (void)ticks;
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
    // After a halt the timer still makes the step that it holds already.
    if (board_halted()) {
        allow_at_most(1);
    }
    if (part_permit_high() && !judged.permit_given) {
        judge_broken(JUDGE_PERMIT);
    }
}

// An AVR accesses words in two halves, so that shared words must be accessed with interrupts off.
// Exceptions are words of which the reader takes the low byte only, and words that the protocol of
// the pulse trains keeps apart.
void judge_access(const struct part_access *access)
{
    if (access->bytes > 1 && part.interrupts_on && !board_excused(access)) {
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

static void come_to_rest(void)
{
    uint32_t quiet = 0;

    for (uint32_t i = 0; quiet < IDLE_AT_REST; i++) {
        int32_t position = judged.position;
        if (i == REST_MAX) {
            judge_broken(JUDGE_RUNAWAY);
        }
        board_idle();
        quiet = judged.position == position ? quiet + 1u : 0;
    }
}

void judge_rest(void)
{
    come_to_rest();
    if (part_estop_pressed() && !board_estop_recorded()) {
        judge_broken(JUDGE_ESTOP);
    }
    if (board_position() != judged.position) {
        judge_broken(JUDGE_POSITION);
    }
    if (!board_recovers()) {
        judge_broken(JUDGE_STUCK);
    }
}
