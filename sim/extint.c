// SPDX-License-Identifier: MIT

#include "extint.h"

#include <string.h>

#include <sim_regbit.h>

#include "access.h"

enum { ON_LOW = 0, ON_ANY = 1, ON_FALL = 2, ON_RISE = 3 };

static avr_int_vector_t *vector_of(const struct extint *e, int line)
{
    return &e->part->eint[line].vector;
}

static unsigned sense_bits(const struct extint *e, int line)
{
    return avr_regbit_get(e->avr, e->part->eint[line].isc[0]) |
           (unsigned)(avr_regbit_get(e->avr, e->part->eint[line].isc[1]) << 1);
}

static bool is_sensed(const struct extint *e, int line, bool rises)
{
    switch (sense_bits(e, line)) {
    case ON_ANY:
        return true;
    case ON_FALL:
        return !rises;
    case ON_RISE:
        return rises;
    default:
        return false;
    }
}

static void raise_line(struct extint *e, int line, uint64_t cycle)
{
    peripheral_raise(e->host, e->avr, vector_of(e, line), cycle);
}

static void raise_due(struct extint *e, uint64_t cycle)
{
    for (int i = 0; i < e->lines; i++) {
        if (e->line[i].flag_due <= cycle) {
            uint64_t due = e->line[i].flag_due;

            e->line[i].flag_due = EXTINT_NEVER;
            raise_line(e, i, due);
        }
    }
}

static uint64_t next_due(const struct extint *e)
{
    uint64_t due = EXTINT_NEVER;

    for (int i = 0; i < e->lines; i++) {
        due = (e->line[i].flag_due < due) ? e->line[i].flag_due : due;
    }
    return due;
}

static avr_cycle_count_t on_flag_due(avr_t *avr, avr_cycle_count_t when, void *param)
{
    struct extint *e = param;

    (void)when;
    raise_due(e, avr->cycle);
    return (next_due(e) == EXTINT_NEVER) ? 0 : next_due(e);
}

static void schedule_next(struct extint *e)
{
    uint64_t due = next_due(e);

    if (due != EXTINT_NEVER) {
        peripheral_schedule(e->avr, due, on_flag_due, e);
    }
}

static void follow_line(struct extint *e, int line, uint64_t cycle)
{
    bool level = ports_level(e->ports, e->line[line].port, e->line[line].bit);

    if (level == e->line[line].level) {
        return;
    }
    e->line[line].level = level;
    if (is_sensed(e, line, level) && e->line[line].flag_due == EXTINT_NEVER) {
        e->line[line].flag_due = cycle + EXTINT_SYNC_CYCLES;
        schedule_next(e);
    }
}

void extint_pins_changed(struct extint *e, char port, uint64_t cycle)
{
    for (int i = 0; i < e->lines; i++) {
        if (e->line[i].port == port) {
            follow_line(e, i, cycle);
        }
    }
}

// ---- the program's view ----

static void follow_registers(struct extint *e, int line, uint64_t cycle)
{
    avr_int_vector_t *vector = vector_of(e, line);
    bool enabled = avr_regbit_get(e->avr, vector->enable) != 0;

    if (!enabled) {
        vector->pending = 0;
    } else if (sense_bits(e, line) == ON_LOW) {
        peripheral_refuse(
            e->host, "INT%d: low level (ISC%d1:0 = 0) is not modelled", line, line);
    } else if (avr_regbit_get(e->avr, vector->raised) != 0 && !vector->pending) {
        raise_line(e, line, cycle);
    }
}

// EIMSK and EICRx.
static void write_control(avr_t *avr, avr_io_addr_t address, uint8_t value, void *param)
{
    struct extint *e = param;

    raise_due(e, access_cycle(avr));
    avr->data[address] = value;
    for (int i = 0; i < e->lines; i++) {
        follow_registers(e, i, access_cycle(avr) + 1);
    }
}

static uint8_t read_flags(avr_t *avr, avr_io_addr_t address, void *param)
{
    raise_due(param, access_cycle(avr));
    return avr->data[address];
}

static void write_flags(avr_t *avr, avr_io_addr_t address, uint8_t value, void *param)
{
    struct extint *e = param;
    uint8_t cleared = access_flags_written(avr, value);

    raise_due(e, access_cycle(avr));
    avr->data[address] &= (uint8_t)~cleared;
    for (int i = 0; i < e->lines; i++) {
        if ((cleared & (1U << vector_of(e, i)->raised.bit)) != 0) {
            avr_clear_interrupt(avr, vector_of(e, i));
        }
    }
}

// ---- attaching and reset ----

void extint_reset(struct extint *e)
{
    for (int i = 0; i < e->lines; i++) {
        e->line[i].flag_due = EXTINT_NEVER;
        e->line[i].level = ports_level(e->ports, e->line[i].port, e->line[i].bit);
    }
}

// simavr has the ATmega1284P's INT2 on PB3; by the data sheet it is on PB2.
static void correct_pins(struct extint *e)
{
    if (strcmp(e->avr->mmcu, "atmega1284") == 0) {
        e->line[2].bit = 2;
    }
}

void extint_attach(struct extint *e,
                   avr_t *avr,
                   const struct peripheral_host *host,
                   const struct ports *ports)
{
    memset(e, 0, sizeof *e);
    e->avr = avr;
    e->part = peripheral_find(avr, "extint", "external interrupts");
    e->host = host;
    e->ports = ports;
    e->part->io.reset = NULL; // it never connects itself to the pins
    while (e->lines < EXTINT_COUNT && e->part->eint[e->lines].port_ioctl != 0) {
        int i = e->lines++;

        e->line[i].port = (char)(e->part->eint[i].port_ioctl & 0x7FU);
        e->line[i].bit = e->part->eint[i].port_pin;
        e->line[i].flag_due = EXTINT_NEVER;
        e->listening |= 1U << (unsigned)(e->line[i].port - 'A');
        access_take(avr, e->part->eint[i].isc[0].reg, NULL, write_control, e);
    }
    correct_pins(e);
    access_take(avr, vector_of(e, 0)->enable.reg, NULL, write_control, e);
    access_take(avr, vector_of(e, 0)->raised.reg, read_flags, write_flags, e);
}
