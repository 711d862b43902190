// SPDX-License-Identifier: MIT
//
// What leaves a board: STEP, DIR, ENABLE and the serial driver, with exact cycles. A pin that its
// program does not drive counts as low.

#include "board.h"

#include <string.h>

#include <avr_ioport.h>

#include "access.h"

#define STEP_CHANNEL 1 // STEP is OCnB

static unsigned port_index(char port)
{
    return (unsigned)(port - 'A');
}

static bool port_level(const struct board *b, const struct board_pin *pin)
{
    unsigned port = port_index(pin->port);

    return ((b->pins[port].port & b->pins[port].ddr) >> pin->bit & 1U) != 0;
}

struct timer16 *board_axis_timer(struct board *b, unsigned axis)
{
    for (int i = 0; i < b->timers; i++) {
        if (b->timer[i].name == b->kind->axis_timer[axis]) {
            return &b->timer[i];
        }
    }
    return NULL;
}

static bool step_level(struct board *b, const struct board_pin *pin)
{
    const struct timer16 *timer = board_axis_timer(b, pin->axis);
    bool driven = ((unsigned)b->pins[port_index(pin->port)].ddr >> pin->bit & 1U) != 0;

    if (timer == NULL || timer16_com(timer, STEP_CHANNEL) == 0) {
        return port_level(b, pin);
    }
    return driven && timer->oc_level[STEP_CHANNEL];
}

static void add_edge(
    struct board *b, unsigned axis, enum edge_signal signal, bool level, uint64_t cycle)
{
    struct edge edge = {
        .cycle = cycle,
        .board = (uint8_t)b->index,
        .axis = (uint8_t)axis,
        .signal = (uint8_t)signal,
        .level = level ? 1 : 0,
    };

    edges_add(b->edges, &edge);
}

void board_log_plant(struct board *b, unsigned axis, uint64_t cycle)
{
    const struct plant *plant = &b->axis[axis].plant;
    struct plant_row row = {
        .cycle = cycle,
        .motor = plant->motor,
        .load = plant->load,
        .board = (uint8_t)b->index,
        .axis = (uint8_t)axis,
    };

    if (b->plant_log != NULL && plant->settings.present) {
        plant_log_add(b->plant_log, &row);
    }
}

static void step_edge(struct board *b, unsigned axis, bool level, uint64_t cycle)
{
    struct board_axis *a = &b->axis[axis];
    int direction = a->dir ? -1 : 1;

    a->step = level;
    add_edge(b, axis, EDGE_STEP, level, cycle);
    if (level) {
        a->steps_rising++;
        a->step_cycles[1] = a->step_cycles[0];
        a->step_cycles[0] = cycle;
        a->steps_signed += direction;
        int64_t motor_before = a->plant.motor;

        if (plant_step(&a->plant, direction)) {
            board_follow_plant(b, axis, cycle);
        }
        if (a->plant.motor != motor_before) {
            board_log_plant(b, axis, cycle);
        }
    }
}

void board_compare_output(void *board, struct timer16 *timer, int channel, uint64_t cycle)
{
    struct board *b = board;

    if (channel != STEP_CHANNEL) {
        return;
    }
    for (unsigned axis = 0; axis < (unsigned)b->kind->axes; axis++) {
        const struct board_pin *pin = board_kind_pin(b->kind, SIGNAL_STEP, axis);

        if (pin != NULL && b->kind->axis_timer[axis] == timer->name) {
            bool level = step_level(b, pin);

            if (level != b->axis[axis].step) {
                step_edge(b, axis, level, cycle);
            }
        }
    }
}

bool board_may_send(void *board)
{
    const struct board *b = board;
    const struct board_pin *pin = board_kind_pin(b->kind, SIGNAL_RS485_DE, 0);

    // A program that leaves the pin alone talks over the board's USB bridge, which is always on.
    if (pin == NULL ||
        ((unsigned)b->pins[port_index(pin->port)].ddr >> pin->bit & 1U) == 0) {
        return true;
    }
    return port_level(b, pin);
}

static void follow_permit(struct board *b, bool level, uint64_t cycle)
{
    if (level != b->permit.level) {
        b->permit.level = level;
        b->permit.changes++;
        b->permit.cycle = cycle;
        b->permit.rise = level ? cycle : b->permit.rise;
        add_edge(b, 0, EDGE_PERMIT, level, cycle);
    }
}

static void follow(struct board *b, const struct board_pin *pin, uint64_t cycle)
{
    struct board_axis *a = &b->axis[pin->axis];

    if (pin->signal == SIGNAL_STEP) {
        bool level = step_level(b, pin);

        if (level != a->step) {
            step_edge(b, pin->axis, level, cycle);
        }
    } else if (pin->signal == SIGNAL_DIR && port_level(b, pin) != a->dir) {
        a->dir = !a->dir;
        add_edge(b, pin->axis, EDGE_DIR, a->dir, cycle);
    } else if (pin->signal == SIGNAL_ENABLE && port_level(b, pin) != a->enable) {
        a->enable = !a->enable;
        add_edge(b, pin->axis, EDGE_ENABLE, a->enable, cycle);
    } else if (pin->signal == SIGNAL_PERMIT) {
        follow_permit(b, port_level(b, pin), cycle);
    } else if (pin->signal == SIGNAL_RS485_DE && !board_may_send(b)) {
        uart_driver_off(&b->uart, cycle);
    }
}

// DIR before STEP would matter only if one write moved both; the pins are looked at in table order.
static void follow_port(struct board *b, unsigned port, uint64_t cycle)
{
    for (int i = 0; i < b->timers; i++) {
        timer16_sync(&b->timer[i], cycle); // edges of before this write come first
    }
    for (size_t i = 0; i < b->kind->pin_count; i++) {
        if (port_index(b->kind->pins[i].port) == port) {
            follow(b, &b->kind->pins[i], cycle);
        }
    }
    board_follow_inputs(b, port, cycle);
}

static void on_port(struct avr_irq_t *irq, uint32_t value, void *param)
{
    struct board *b = param;

    b->pins[irq->irq].port = (uint8_t)value;
    follow_port(b, irq->irq, access_cycle(b->avr) + 1);
}

static void on_ddr(struct avr_irq_t *irq, uint32_t value, void *param)
{
    struct board *b = param;

    b->pins[irq->irq].ddr = (uint8_t)value;
    follow_port(b, irq->irq, access_cycle(b->avr) + 1);
}

static avr_ioport_t *find_port(const struct board *b, char name)
{
    for (avr_io_t *io = b->avr->io_port; io != NULL; io = io->next) {
        avr_ioport_t *port = (avr_ioport_t *)(void *)io;

        if (strcmp(io->kind, "port") == 0 && port->name == name) {
            return port;
        }
    }
    return NULL;
}

// What simavr remembers of a port, so that it tells of the next change.
static void forget_outputs(struct board *b, avr_ioport_t *port)
{
    port->io.irq[IOPORT_IRQ_DIRECTION_ALL].value = 0;
    port->io.irq[IOPORT_IRQ_REG_PORT].value = 0;
    b->avr->data[port->r_pin] = 0;
    for (unsigned bit = 0; bit < 8; bit++) {
        bool level = board_pin_level(b, port->name, bit);

        port->io.irq[bit].value = level ? 1 : 0;
        b->avr->data[port->r_pin] |= (uint8_t)((level ? 1U : 0U) << bit);
    }
}

void board_release_outputs(struct board *b)
{
    for (unsigned index = 0; index < BOARD_PORTS; index++) {
        avr_ioport_t *port = find_port(b, (char)('A' + index));

        b->pins[index].port = b->pins[index].ddr = 0;
        if (port != NULL) {
            forget_outputs(b, port);
            follow_port(b, index, b->avr->cycle);
        }
    }
}

void board_watch_outputs(struct board *b)
{
    for (unsigned port = 0; port < BOARD_PORTS; port++) {
        uint32_t which = AVR_IOCTL_IOPORT_GETIRQ((uint32_t)'A' + port);
        avr_irq_t *written = avr_io_getirq(b->avr, which, IOPORT_IRQ_REG_PORT);
        avr_irq_t *turned = avr_io_getirq(b->avr, which, IOPORT_IRQ_DIRECTION_ALL);

        if (written != NULL && turned != NULL) {
            written->irq = turned->irq = port; // how the notify knows its port
            avr_irq_register_notify(written, on_port, b);
            avr_irq_register_notify(turned, on_ddr, b);
        }
    }
}
