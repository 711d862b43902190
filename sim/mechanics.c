// SPDX-License-Identifier: MIT

#include "mechanics.h"

static void drive_switch_pin(struct mechanics *m,
                             unsigned axis,
                             unsigned which,
                             uint64_t cycle)
{
    const struct board_pin *pin =
        switches_pin(m->switches, axis, (enum plant_switch)which);
    const struct mechanics_axis *a = &m->axis[axis];

    if (pin != NULL && plant_has(&a->plant, which)) {
        bool level = a->contact[which].closed == a->plant.settings.active_high;

        inputs_drive(m->inputs, pin->port, pin->bit, level, cycle);
    }
}

static void move_contact(struct mechanics *m, unsigned axis, unsigned which)
{
    struct mechanics_axis *a = &m->axis[axis];
    struct switch_state *state = &m->switches->state[axis][which];
    uint64_t first_cycle = state->first_cycle;
    struct contact_edge edge;

    if (contact_move(&a->contact[which], &a->plant.settings.contact, &edge)) {
        drive_switch_pin(m, axis, which, edge.cycle);
        if (edge.bounce) { // the change began earlier
            state->first_cycle = first_cycle;
        }
    }
}

// When the next contact does something, and which one.
static uint64_t next_due(const struct mechanics *m, unsigned *axis, unsigned *which)
{
    uint64_t next = CONTACT_NEVER;

    for (unsigned i = 0; i < (unsigned)m->axes * PLANT_SWITCHES; i++) {
        const struct mechanics_axis *a = &m->axis[i / PLANT_SWITCHES];
        uint64_t due = contact_due(&a->contact[i % PLANT_SWITCHES]);

        if (due < next) {
            next = due;
            *axis = i / PLANT_SWITCHES;
            *which = i % PLANT_SWITCHES;
        }
    }
    return next;
}

static avr_cycle_count_t on_contact_due(avr_t *avr, avr_cycle_count_t when, void *param)
{
    struct mechanics *m = param;
    unsigned axis = 0;
    unsigned which = 0;
    uint64_t due;

    (void)when;
    while ((due = next_due(m, &axis, &which)) <= avr->cycle) {
        move_contact(m, axis, which);
    }
    return (due == CONTACT_NEVER) ? 0 : due;
}

void mechanics_schedule(struct mechanics *m)
{
    unsigned axis;
    unsigned which;
    uint64_t due = next_due(m, &axis, &which);

    if (due != CONTACT_NEVER) {
        peripheral_schedule(m->avr, due, on_contact_due, m);
    }
}

static void follow_switches(struct mechanics *m, unsigned axis, uint64_t cycle)
{
    struct mechanics_axis *a = &m->axis[axis];

    for (unsigned i = 0; i < PLANT_SWITCHES; i++) {
        if (!contact_follow(
                &a->contact[i], &a->plant.settings.contact, a->plant.closed[i], cycle)) {
            peripheral_refuse(
                m->host,
                "axis %u: more than %d changes of a switch within its delay",
                axis,
                CONTACT_CHANGES);
        }
    }
    mechanics_schedule(m);
}

static void log_position(struct mechanics *m, unsigned axis, uint64_t cycle)
{
    const struct plant *plant = &m->axis[axis].plant;
    struct plant_row row = {
        .cycle = own_time_to_bench(m->switches->time, cycle),
        .motor = plant->motor,
        .load = plant->load,
        .board = (uint8_t)m->board,
        .axis = (uint8_t)axis,
    };

    if (m->log != NULL && plant->settings.present) {
        plant_log_add(m->log, &row);
    }
}

void mechanics_step(struct mechanics *m, unsigned axis, int direction, uint64_t cycle)
{
    struct plant *plant = &m->axis[axis].plant;
    int64_t motor_before = plant->motor;

    if (plant_step(plant, direction)) {
        follow_switches(m, axis, cycle);
    }
    if (plant->motor != motor_before) {
        log_position(m, axis, cycle);
    }
}

// A number of its own for every switch of a bench, so that no two bounce alike.
static unsigned place_of(const struct mechanics *m, unsigned axis, unsigned which)
{
    return ((unsigned)m->board * BOARD_AXES + axis) * PLANT_SWITCHES + which;
}

// All contacts are at once what their switches are.
static void settle_contacts(struct mechanics *m, unsigned axis)
{
    struct mechanics_axis *a = &m->axis[axis];

    for (unsigned i = 0; i < PLANT_SWITCHES; i++) {
        if (a->plant.settings.has_seed) {
            contact_seed(&a->contact[i], a->plant.settings.seed, place_of(m, axis, i));
        }
        contact_settle(&a->contact[i], a->plant.closed[i]);
        drive_switch_pin(m, axis, i, m->avr->cycle);
    }
}

void mechanics_set_plant(struct mechanics *m,
                         unsigned axis,
                         const struct plant_settings *settings)
{
    plant_init(&m->axis[axis].plant, settings);
    settle_contacts(m, axis);
    log_position(m, axis, m->avr->cycle);
}

void mechanics_change_plant(struct mechanics *m,
                            unsigned axis,
                            const struct plant_settings *settings)
{
    plant_change(&m->axis[axis].plant, settings);
    settle_contacts(m, axis);
    log_position(m, axis, m->avr->cycle);
}

void mechanics_attach(struct mechanics *m,
                      avr_t *avr,
                      const struct peripheral_host *host,
                      struct inputs *inputs,
                      struct switches *switches)
{
    m->avr = avr;
    m->host = host;
    m->inputs = inputs;
    m->switches = switches;
    m->board = switches->board;
    m->axes = switches->kind->axes;
}
