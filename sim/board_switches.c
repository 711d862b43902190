// SPDX-License-Identifier: MIT
//
// The home and limit switches of a board's axes: from the mechanics through their contacts to the
// pins, each edge in its exact cycle, and the log of what the pins saw.

#include <inttypes.h>
#include <stdio.h>

#include "board.h"

static const enum board_signal signals[PLANT_SWITCHES] = {
    [PLANT_HOME] = SIGNAL_HOME,
    [PLANT_LIMIT_MINUS] = SIGNAL_LIMIT_MINUS,
    [PLANT_LIMIT_PLUS] = SIGNAL_LIMIT_PLUS,
};

static const char *const names[PLANT_SWITCHES] = {"home", "minus", "plus"};

static void drive(struct board *b, unsigned axis, unsigned which, uint64_t cycle)
{
    const struct board_pin *pin = board_kind_pin(b->kind, signals[which], axis);
    const struct board_axis *a = &b->axis[axis];

    if (pin != NULL && plant_has(&a->plant, which)) {
        bool level = a->contact[which].closed == a->plant.settings.active_high;

        board_drive_pin(b, pin->port, pin->bit, level, cycle);
    }
}

static void move(struct board *b, unsigned axis, unsigned which)
{
    struct board_axis *a = &b->axis[axis];
    struct board_switch *log = &a->switches[which];
    uint64_t first_cycle = log->first_cycle;
    struct contact_edge edge;

    if (contact_move(&a->contact[which], &a->plant.settings.contact, &edge)) {
        drive(b, axis, which, edge.cycle);
        if (edge.bounce) {
            log->first_cycle = first_cycle;
        }
    }
}

// When the next contact does something, and which one.
static uint64_t next_due(const struct board *b, unsigned *axis, unsigned *which)
{
    uint64_t next = CONTACT_NEVER;

    for (unsigned i = 0; i < (unsigned)b->kind->axes * PLANT_SWITCHES; i++) {
        const struct board_axis *a = &b->axis[i / PLANT_SWITCHES];
        uint64_t due = contact_due(&a->contact[i % PLANT_SWITCHES]);

        if (due < next) {
            next = due;
            *axis = i / PLANT_SWITCHES;
            *which = i % PLANT_SWITCHES;
        }
    }
    return next;
}

static avr_cycle_count_t on_switch(avr_t *avr, avr_cycle_count_t when, void *param)
{
    struct board *b = param;
    unsigned axis = 0;
    unsigned which = 0;
    uint64_t due;

    (void)when;
    while ((due = next_due(b, &axis, &which)) <= avr->cycle) {
        move(b, axis, which);
    }
    return (due == CONTACT_NEVER) ? 0 : due;
}

void board_schedule_switches(struct board *b)
{
    unsigned axis;
    unsigned which;
    uint64_t due = next_due(b, &axis, &which);

    if (due != CONTACT_NEVER) {
        avr_cycle_timer_register(
            b->avr, (due > b->avr->cycle) ? due - b->avr->cycle : 0, on_switch, b);
    }
}

void board_follow_plant(struct board *b, unsigned axis, uint64_t cycle)
{
    struct board_axis *a = &b->axis[axis];
    char text[96];

    for (unsigned i = 0; i < PLANT_SWITCHES; i++) {
        if (!contact_follow(
                &a->contact[i], &a->plant.settings.contact, a->plant.closed[i], cycle)) {
            (void)snprintf(text,
                           sizeof text,
                           "axis %u: more than %d changes of a switch within its delay",
                           axis,
                           CONTACT_CHANGES);
            board_refuse(b, text);
        }
    }
    board_schedule_switches(b);
}

// A number of its own for every switch of a bench, so that no two bounce alike.
static unsigned place_of(const struct board *b, unsigned axis, unsigned which)
{
    return ((unsigned)b->index * BOARD_AXES + axis) * PLANT_SWITCHES + which;
}

// All contacts are at once what their switches are.
static void settle(struct board *b, unsigned axis)
{
    struct board_axis *a = &b->axis[axis];

    for (unsigned i = 0; i < PLANT_SWITCHES; i++) {
        if (a->plant.settings.has_seed) {
            contact_seed(&a->contact[i], a->plant.settings.seed, place_of(b, axis, i));
        }
        contact_settle(&a->contact[i], a->plant.closed[i]);
        drive(b, axis, i, b->avr->cycle);
    }
}

void board_set_plant(struct board *b,
                     unsigned axis,
                     const struct plant_settings *settings)
{
    plant_init(&b->axis[axis].plant, settings);
    settle(b, axis);
    board_log_plant(b, axis, b->avr->cycle);
}

void board_change_plant(struct board *b,
                        unsigned axis,
                        const struct plant_settings *settings)
{
    plant_change(&b->axis[axis].plant, settings);
    settle(b, axis);
    board_log_plant(b, axis, b->avr->cycle);
}

bool board_switch_level(struct board *b, unsigned axis, unsigned which)
{
    const struct board_pin *pin = board_kind_pin(b->kind, signals[which], axis);

    return pin != NULL && board_pin_level(b, pin->port, pin->bit);
}

// Which switch is on a pin: its place among a board's switches, from 1 on; 0 for none.
void board_find_switches(struct board *b)
{
    for (unsigned i = 0; i < (unsigned)b->kind->axes * PLANT_SWITCHES; i++) {
        const struct board_pin *pin =
            board_kind_pin(b->kind, signals[i % PLANT_SWITCHES], i / PLANT_SWITCHES);

        if (pin != NULL) {
            b->switch_on[(unsigned)(pin->port - 'A')][pin->bit] = (uint8_t)(i + 1U);
        }
    }
}

static void write_row(const struct board *b,
                      unsigned axis,
                      unsigned which,
                      uint64_t cycle)
{
    if (b->switch_log != NULL) {
        (void)fprintf(b->switch_log,
                      "%" PRIu64 ",%d,%u,%s,%d\n",
                      cycle,
                      b->index,
                      axis,
                      names[which],
                      b->axis[axis].switches[which].level);
    }
}

void board_log_switch(
    struct board *b, unsigned port, unsigned bit, bool level, uint64_t cycle)
{
    unsigned place = b->switch_on[port][bit];

    if (place != 0) {
        unsigned axis = (place - 1U) / PLANT_SWITCHES;
        unsigned which = (place - 1U) % PLANT_SWITCHES;
        struct board_switch *log = &b->axis[axis].switches[which];

        if (log->level != level) {
            log->level = level;
            log->cycle = log->first_cycle = cycle;
            write_row(b, axis, which, cycle);
        }
    }
}
