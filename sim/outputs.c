// SPDX-License-Identifier: MIT

#include "outputs.h"

#define STEP_CHANNEL 1 // STEP is OCnB

static bool is_high(const struct outputs *o, const struct board_pin *pin)
{
    return ports_is_high_output(o->ports, pin->port, pin->bit);
}

struct timer16 *outputs_axis_timer(const struct outputs *o, unsigned axis)
{
    return timers_by_name(o->timers, o->kind->axis_timer[axis]);
}

static bool step_level(const struct outputs *o, const struct board_pin *pin)
{
    const struct timer16 *timer = outputs_axis_timer(o, pin->axis);

    if (timer == NULL || timer16_com(timer, STEP_CHANNEL) == 0) {
        return is_high(o, pin);
    }
    return ports_is_output(o->ports, pin->port, pin->bit) &&
           timer->oc_level[STEP_CHANNEL];
}

static void add_edge(
    struct outputs *o, unsigned axis, enum edge_signal signal, bool level, uint64_t cycle)
{
    struct edge edge = {
        .cycle = own_time_to_bench(o->time, cycle),
        .board = (uint8_t)o->board,
        .axis = (uint8_t)axis,
        .signal = (uint8_t)signal,
        .level = level ? 1 : 0,
    };

    edges_add(o->edges, &edge);
}

static void add_step_edge(struct outputs *o, unsigned axis, bool level, uint64_t cycle)
{
    struct outputs_axis *a = &o->axis[axis];
    int direction = a->dir ? -1 : 1;

    a->step = level;
    add_edge(o, axis, EDGE_STEP, level, cycle);
    if (level) {
        a->steps_rising++;
        a->step_cycles[1] = a->step_cycles[0];
        a->step_cycles[0] = own_time_to_bench(o->time, cycle);
        a->steps_signed += direction;
        mechanics_step(o->mechanics, axis, direction, cycle);
    }
}

static void follow_step(struct outputs *o, const struct board_pin *pin, uint64_t cycle)
{
    bool level = step_level(o, pin);

    if (level != o->axis[pin->axis].step) {
        add_step_edge(o, pin->axis, level, cycle);
    }
}

void outputs_follow_compare(struct outputs *o,
                            const struct timer16 *timer,
                            int channel,
                            uint64_t cycle)
{
    if (channel != STEP_CHANNEL) {
        return;
    }
    for (unsigned axis = 0; axis < (unsigned)o->kind->axes; axis++) {
        const struct board_pin *pin = board_kind_pin(o->kind, SIGNAL_STEP, axis);

        if (pin != NULL && o->kind->axis_timer[axis] == timer->name) {
            follow_step(o, pin, cycle);
        }
    }
}

bool outputs_may_send(const struct outputs *o)
{
    const struct board_pin *pin = board_kind_pin(o->kind, SIGNAL_RS485_DE, 0);

    return pin == NULL || !ports_is_output(o->ports, pin->port, pin->bit) ||
           is_high(o, pin);
}

static void follow_permit(struct outputs *o, bool level, uint64_t cycle)
{
    struct outputs_permit *permit = &o->permit;

    if (level != permit->level) {
        permit->level = level;
        permit->changes++;
        permit->cycle = own_time_to_bench(o->time, cycle);
        permit->rise = level ? permit->cycle : permit->rise;
        add_edge(o, 0, EDGE_PERMIT, level, cycle);
    }
}

// Without a compare output of timer 0 at the pin the program makes the clock.
static bool clock_out_level(const struct outputs *o, const struct board_pin *pin)
{
    if (o->kind->clock_out_is_oc0b && timer0_is_connected(o->timer0)) {
        return ports_is_output(o->ports, pin->port, pin->bit) && o->timer0->oc_level;
    }
    return is_high(o, pin);
}

static void follow_clock_out(struct outputs *o,
                             const struct board_pin *pin,
                             uint64_t cycle)
{
    bool level = clock_out_level(o, pin);

    if (level != o->clock_out) {
        o->clock_out = level;
        add_edge(o, 0, EDGE_CLOCK_OUT, level, cycle);
        o->hooks->clock_out(o->hooks->board, level, cycle);
    }
}

void outputs_follow_timer0(struct outputs *o, uint64_t cycle)
{
    const struct board_pin *pin = board_kind_pin(o->kind, SIGNAL_CLOCK_OUT, 0);

    if (pin != NULL) {
        follow_clock_out(o, pin, cycle);
    }
}

static void follow_pin(struct outputs *o, const struct board_pin *pin, uint64_t cycle)
{
    struct outputs_axis *a = &o->axis[pin->axis];

    if (pin->signal == SIGNAL_STEP) {
        follow_step(o, pin, cycle);
    } else if (pin->signal == SIGNAL_DIR && is_high(o, pin) != a->dir) {
        a->dir = !a->dir;
        add_edge(o, pin->axis, EDGE_DIR, a->dir, cycle);
    } else if (pin->signal == SIGNAL_ENABLE && is_high(o, pin) != a->enable) {
        a->enable = !a->enable;
        add_edge(o, pin->axis, EDGE_ENABLE, a->enable, cycle);
    } else if (pin->signal == SIGNAL_PERMIT) {
        follow_permit(o, is_high(o, pin), cycle);
    } else if (pin->signal == SIGNAL_CLOCK_OUT) {
        follow_clock_out(o, pin, cycle);
    } else if (pin->signal == SIGNAL_RS485_DE && !outputs_may_send(o)) {
        uart_driver_off(o->uart, cycle);
    }
}

// The order of the pins is that of the board's table. It would matter only if one write moved both
// DIR and STEP.
void outputs_follow_port(struct outputs *o, unsigned port, uint64_t cycle)
{
    char name = (char)('A' + port);

    timers_sync(o->timers, cycle); // edges from before this write come first
    for (size_t i = 0; i < o->kind->pin_count; i++) {
        if (o->kind->pins[i].port == name) {
            follow_pin(o, &o->kind->pins[i], cycle);
        }
    }
}
