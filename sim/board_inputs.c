// SPDX-License-Identifier: MIT
//
// What comes into a board: input pins, and the pixel clock with its edges' exact cycles.

#include <string.h>

#include <avr_ioport.h>

#include "board.h"

void board_find_icp(struct board *b, int timer)
{
    const avr_regbit_t icp = b->timer[timer].part->icp;

    for (const avr_io_t *io = b->avr->io_port; io != NULL; io = io->next) {
        const avr_ioport_t *port = (const avr_ioport_t *)(const void *)io;

        if (strcmp(io->kind, "port") == 0 &&
            (icp.reg == port->r_port || icp.reg == port->r_pin)) {
            b->icp[timer].port = port->name;
            b->icp[timer].bit = (uint8_t)icp.bit;
        }
    }
}

// What the pin reads: its own output, else what drives it from outside, else its pull-up.
bool board_pin_level(void *board, char port, unsigned bit)
{
    const struct board *b = board;
    unsigned index = (unsigned)(port - 'A');
    uint8_t mask = (uint8_t)(1U << bit);

    if ((b->pins[index].ddr & mask) == 0 && (b->pins[index].driven_mask & mask) != 0) {
        return (b->pins[index].driven_level & mask) != 0;
    }
    return (b->pins[index].port & mask) != 0;
}

// The comparator takes the place of timer 1's pin.
static bool follows_comparator(const struct board *b, int timer)
{
    return b->timer[timer].name == '1' && comparator_captures(&b->comparator);
}

void board_follow_inputs(struct board *b, unsigned port, uint64_t cycle)
{
    char name = (char)('A' + port);

    for (int i = 0; i < b->timers; i++) {
        if (b->icp[i].port == name && !follows_comparator(b, i)) {
            timer16_icp(&b->timer[i], board_pin_level(b, name, b->icp[i].bit), cycle);
        }
    }
    comparator_follow(&b->comparator, name, cycle);
    extint_follow(&b->extint, name, cycle);
}

void board_follow_comparator(void *board, uint64_t cycle)
{
    struct board *b = board;

    for (int i = 0; i < b->timers; i++) {
        if (b->timer[i].name == '1') {
            bool level = follows_comparator(b, i)
                             ? b->comparator.output
                             : board_pin_level(b, b->icp[i].port, b->icp[i].bit);

            timer16_icp(&b->timer[i], level, cycle);
        }
    }
}

static void log_wire(
    const struct board *b, char port, unsigned bit, bool level, uint64_t cycle)
{
    unsigned index = (unsigned)(port - 'A');
    bool driven = (b->pins[index].driven_mask >> bit & 1U) != 0;
    bool before = (b->pins[index].driven_level >> bit & 1U) != 0;

    if (b->wire_log != NULL && (!driven || before != level)) {
        wire_log_pin(b->wire_log, port, bit, level, cycle);
    }
}

void board_drive_pin(struct board *b, char port, unsigned bit, bool level, uint64_t cycle)
{
    unsigned index = (unsigned)(port - 'A');
    uint8_t mask = (uint8_t)(1U << bit);
    avr_ioport_external_t external = {.name = (unsigned char)port & 0x7FU};
    avr_irq_t *pin =
        avr_io_getirq(b->avr, AVR_IOCTL_IOPORT_GETIRQ((uint32_t)port), (int)bit);

    if (pin == NULL || index >= BOARD_PORTS) {
        return;
    }
    log_wire(b, port, bit, level, cycle);
    b->pins[index].driven_mask |= mask;
    b->pins[index].driven_level =
        (uint8_t)((b->pins[index].driven_level & ~mask) | (level ? mask : 0));
    // Without this, simavr forgets the level at the program's next write to the port.
    external.mask = b->pins[index].driven_mask;
    external.value = b->pins[index].driven_level;
    (void)avr_ioctl(b->avr, AVR_IOCTL_IOPORT_SET_EXTERNAL((uint32_t)port), &external);
    avr_raise_irq(pin, level ? 1 : 0);
    board_log_switch(b, index, bit, level, cycle);
    board_follow_inputs(b, index, cycle);
}

static avr_cycle_count_t on_pulse(avr_t *avr, avr_cycle_count_t when, void *param)
{
    struct board *b = param;

    (void)when;
    while (b->pulse_first != b->pulse_last) {
        const struct pixel_pulse *pulse = &b->pulse[b->pulse_first % BOARD_PULSES];
        uint64_t due = b->pulse_high ? pulse->fall : pulse->rise;
        const struct board_pin *in = board_kind_pin(b->kind, SIGNAL_PIXEL_CLOCK, 0);
        const struct board_pin *copy =
            board_kind_pin(b->kind, SIGNAL_PIXEL_CLOCK_COPY, 0);

        if (due > avr->cycle) {
            return due;
        }
        b->pulse_high = !b->pulse_high;
        b->pulse_first += b->pulse_high ? 0 : 1;
        board_drive_pin(b, in->port, in->bit, b->pulse_high, due);
        if (copy != NULL) {
            board_drive_pin(b, copy->port, copy->bit, b->pulse_high, due);
        }
    }
    return 0;
}

void board_schedule_pulse(struct board *b)
{
    const struct pixel_pulse *pulse = &b->pulse[b->pulse_first % BOARD_PULSES];
    uint64_t due = b->pulse_high ? pulse->fall : pulse->rise;

    if (b->pulse_first != b->pulse_last) {
        avr_cycle_timer_register(
            b->avr, (due > b->avr->cycle) ? due - b->avr->cycle : 0, on_pulse, b);
    }
}

bool board_add_pulse(struct board *b, const struct pixel_pulse *pulse)
{
    if (b->pulse_last - b->pulse_first >= BOARD_PULSES) {
        return false;
    }
    b->pulse[b->pulse_last++ % BOARD_PULSES] = *pulse;
    if (b->pulse_last - b->pulse_first == 1) {
        board_schedule_pulse(b);
    }
    if (b->index == 0) {
        edges_add(b->edges,
                  &(struct edge){.cycle = pulse->rise, .signal = EDGE_CLOCK, .level = 1});
        edges_add(b->edges,
                  &(struct edge){.cycle = pulse->fall, .signal = EDGE_CLOCK, .level = 0});
    }
    return true;
}
