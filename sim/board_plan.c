// SPDX-License-Identifier: MIT
//
// What is to happen to a board from outside at cycles to come: levels of pins, resets, the supply.

#include <string.h>

#include "board.h"

bool board_plan_add(struct board *b, const struct board_deed *deed)
{
    struct board_plan *plan = &b->plan;
    unsigned at = plan->count;

    if (plan->count == BOARD_PLAN) {
        return false;
    }
    // Of the same cycle: in the order in which they were asked for.
    while (at > 0 && plan->deed[at - 1].cycle > deed->cycle) {
        plan->deed[at] = plan->deed[at - 1];
        at--;
    }
    plan->deed[at] = *deed;
    if (plan->deed[at].cycle <
        b->avr->cycle) { // it has passed this by within an instruction
        plan->deed[at].cycle = b->avr->cycle;
    }
    plan->count++;
    board_schedule_plan(b);
    return true;
}

static void take_first(struct board_plan *plan)
{
    plan->count--;
    memmove(&plan->deed[0], &plan->deed[1], plan->count * sizeof plan->deed[0]);
}

// A supply that is already so stays so, and a board without it has nothing to reset.
static bool has_effect(const struct board *b, enum board_want want)
{
    return (want == BOARD_WANT_ON) ? !b->powered : b->powered;
}

static avr_cycle_count_t on_deed(avr_t *avr, avr_cycle_count_t when, void *param)
{
    struct board *b = param;
    struct board_plan *plan = &b->plan;

    (void)when;
    while (plan->count > 0 && plan->deed[0].cycle <= avr->cycle) {
        struct board_deed deed = plan->deed[0];

        take_first(plan);
        if (deed.want == BOARD_WANT_NONE) {
            board_drive_pin(b, deed.port, deed.bit, deed.level, deed.cycle);
        } else if (has_effect(b, deed.want)) {
            board_want(b, deed.want);
            return 0; // the rest is scheduled anew after the reset
        }
    }
    return (plan->count > 0) ? plan->deed[0].cycle : 0;
}

void board_schedule_plan(struct board *b)
{
    const struct board_plan *plan = &b->plan;
    uint64_t now = b->avr->cycle;

    if (plan->count > 0) {
        uint64_t due = plan->deed[0].cycle;

        avr_cycle_timer_register(b->avr, (due > now) ? due - now : 0, on_deed, b);
    }
}
