// SPDX-License-Identifier: MIT
// This file is MIT; the program it is linked into is GPL-3.0 as a whole, because of libsimavr.

#include "extint.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <sim_regbit.h>

#include "access.h"

enum { ON_LOW = 0, ON_ANY = 1, ON_FALL = 2, ON_RISE = 3 };

static avr_int_vector_t *vector_of(const struct extint *x, int line)
{
    return &x->part->eint[line].vector;
}

static unsigned sense(const struct extint *x, int line)
{
    return avr_regbit_get(x->avr, x->part->eint[line].isc[0]) |
           (unsigned)(avr_regbit_get(x->avr, x->part->eint[line].isc[1]) << 1);
}

static bool wanted(const struct extint *x, int line, bool rises)
{
    switch (sense(x, line)) {
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

static void set_flag(struct extint *x, int line, uint64_t cycle)
{
    x->hooks->flag(x->hooks->board, vector_of(x, line)->vector, cycle);
    (void)avr_raise_interrupt(x->avr, vector_of(x, line));
}

static void sync(struct extint *x, uint64_t cycle)
{
    for (int i = 0; i < x->lines; i++) {
        if (x->line[i].flag_due <= cycle) {
            uint64_t due = x->line[i].flag_due;

            x->line[i].flag_due = EXTINT_NEVER;
            set_flag(x, i, due);
        }
    }
}

static uint64_t next_due(const struct extint *x)
{
    uint64_t due = EXTINT_NEVER;

    for (int i = 0; i < x->lines; i++) {
        due = (x->line[i].flag_due < due) ? x->line[i].flag_due : due;
    }
    return due;
}

static avr_cycle_count_t on_due(avr_t *avr, avr_cycle_count_t when, void *param)
{
    struct extint *x = param;

    (void)when;
    sync(x, avr->cycle);
    return (next_due(x) == EXTINT_NEVER) ? 0 : next_due(x);
}

static void schedule(struct extint *x)
{
    uint64_t due = next_due(x);
    uint64_t now = x->avr->cycle;

    if (due != EXTINT_NEVER) {
        avr_cycle_timer_register(x->avr, (due > now) ? due - now : 0, on_due, x);
    }
}

static void follow_line(struct extint *x, int line, uint64_t cycle)
{
    bool level = x->hooks->pin(x->hooks->board, x->line[line].port, x->line[line].bit);

    if (level == x->line[line].level) {
        return;
    }
    x->line[line].level = level;
    if (wanted(x, line, level) && x->line[line].flag_due == EXTINT_NEVER) {
        x->line[line].flag_due = cycle + EXTINT_SYNC_CYCLES;
        schedule(x);
    }
}

void extint_pins_changed(struct extint *x, char port, uint64_t cycle)
{
    for (int i = 0; i < x->lines; i++) {
        if (x->line[i].port == port) {
            follow_line(x, i, cycle);
        }
    }
}

// ---- the program's view ----

static void follow_enable(struct extint *x, int line, uint64_t cycle)
{
    avr_int_vector_t *vector = vector_of(x, line);
    bool enabled = avr_regbit_get(x->avr, vector->enable) != 0;
    char text[80];

    if (!enabled) {
        vector->pending = 0;
    } else if (sense(x, line) == ON_LOW) {
        (void)snprintf(text,
                       sizeof text,
                       "INT%d: low level (ISC%d1:0 = 0) is not modelled",
                       line,
                       line);
        x->hooks->refuse(x->hooks->board, text);
    } else if (avr_regbit_get(x->avr, vector->raised) != 0 && !vector->pending) {
        set_flag(x, line, cycle);
    }
}

// EIMSK and EICRx.
static void write_control(avr_t *avr, avr_io_addr_t address, uint8_t value, void *param)
{
    struct extint *x = param;

    sync(x, access_cycle(avr));
    avr->data[address] = value;
    for (int i = 0; i < x->lines; i++) {
        follow_enable(x, i, access_cycle(avr) + 1);
    }
}

static uint8_t read_flags(avr_t *avr, avr_io_addr_t address, void *param)
{
    sync(param, access_cycle(avr));
    return avr->data[address];
}

static void write_flags(avr_t *avr, avr_io_addr_t address, uint8_t value, void *param)
{
    struct extint *x = param;
    uint8_t cleared = access_flags_written(avr, value);

    sync(x, access_cycle(avr));
    avr->data[address] &= (uint8_t)~cleared;
    for (int i = 0; i < x->lines; i++) {
        if ((cleared & (1U << vector_of(x, i)->raised.bit)) != 0) {
            avr_clear_interrupt(avr, vector_of(x, i));
        }
    }
}

// ---- life ----

void extint_reset(struct extint *x)
{
    for (int i = 0; i < x->lines; i++) {
        x->line[i].flag_due = EXTINT_NEVER;
        x->line[i].level =
            x->hooks->pin(x->hooks->board, x->line[i].port, x->line[i].bit);
    }
}

static avr_extint_t *find_part(avr_t *avr)
{
    for (avr_io_t *io = avr->io_port; io != NULL; io = io->next) {
        if (strcmp(io->kind, "extint") == 0) {
            return (avr_extint_t *)(void *)io;
        }
    }
    (void)fputs("pixstep-sim: simavr's part has no external interrupts\n", stderr);
    abort();
}

void extint_attach(struct extint *x, avr_t *avr, const struct extint_hooks *hooks)
{
    memset(x, 0, sizeof *x);
    x->avr = avr;
    x->part = find_part(avr);
    x->hooks = hooks;
    x->part->io.reset = NULL; // it never connects itself to the pins
    while (x->lines < EXTINT_COUNT && x->part->eint[x->lines].port_ioctl != 0) {
        int i = x->lines++;

        x->line[i].port = (char)(x->part->eint[i].port_ioctl & 0x7FU);
        x->line[i].bit = x->part->eint[i].port_pin;
        x->line[i].flag_due = EXTINT_NEVER;
        x->ports |= 1U << (unsigned)(x->line[i].port - 'A');
        access_take(avr, x->part->eint[i].isc[0].reg, NULL, write_control, x);
    }
    access_take(avr, vector_of(x, 0)->enable.reg, NULL, write_control, x);
    access_take(avr, vector_of(x, 0)->raised.reg, read_flags, write_flags, x);
}
