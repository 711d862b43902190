// SPDX-License-Identifier: MIT
// This file is MIT; the program it is linked into is GPL-3.0 as a whole, because of libsimavr.

#include "watchdog.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <sim_regbit.h>

#include "access.h"

// Bits of WDTCSR.
#define WDIF    0x80U
#define WDIE    0x40U
#define WDP3    0x20U
#define WDCE    0x10U
#define WDE     0x08U
#define WDP2_0  0x07U
#define WDP     (WDP3 | WDP2_0)
#define WDP_TOP 9U

static uint8_t *control(const struct watchdog *w)
{
    return &w->avr->data[w->part->wdce.reg];
}

static bool runs(const struct watchdog *w)
{
    return (*control(w) & (WDE | WDIE)) != 0;
}

static unsigned prescaler(const struct watchdog *w)
{
    return (*control(w) & WDP2_0) | (unsigned)((*control(w) & WDP3) >> 2);
}

static uint64_t due(const struct watchdog *w)
{
    return w->since + (WATCHDOG_SHORTEST_CYCLES << prescaler(w));
}

static void set_flag(struct watchdog *w, uint64_t cycle)
{
    w->hooks->flag(w->hooks->board, w->part->watchdog.vector, cycle);
    (void)avr_raise_interrupt(w->avr, &w->part->watchdog);
}

static void time_out(struct watchdog *w)
{
    uint8_t bits = *control(w);
    bool waited = (bits & WDE) != 0 && (bits & WDIF) != 0;

    if ((bits & WDIE) == 0 || waited) {
        w->hooks->reset(w->hooks->board);
        return;
    }
    set_flag(w, due(w));
}

// WDR only moves what is due away: found out here, so that it costs next to nothing.
static avr_cycle_count_t on_due(avr_t *avr, avr_cycle_count_t when, void *param)
{
    struct watchdog *w = param;

    (void)when;
    if (!runs(w)) {
        return 0;
    }
    if (due(w) <= avr->cycle) {
        uint64_t at = due(w);

        time_out(w);
        w->since = at;
    }
    return due(w);
}

static void schedule(struct watchdog *w)
{
    uint64_t now = w->avr->cycle;

    if (!runs(w)) {
        avr_cycle_timer_cancel(w->avr, on_due, w);
    } else {
        avr_cycle_timer_register(w->avr, (due(w) > now) ? due(w) - now : 0, on_due, w);
    }
}

void watchdog_restart(struct watchdog *w)
{
    w->since = w->avr->cycle + 1;
}

static bool reset_flag_set(const struct watchdog *w)
{
    return avr_regbit_get(w->avr, w->part->wdrf) != 0;
}

// WDIF, WDIE, WDE and WDP after a write of `value`.
static uint8_t written(const struct watchdog *w, uint8_t value, bool may_change)
{
    uint8_t before = *control(w);
    uint8_t locked = (uint8_t)(WDP | (before & WDE)); // WDE can always be set
    uint8_t after = value & (WDIE | WDE | WDP);

    if (!may_change) {
        after = (uint8_t)((after & ~locked) | (before & locked));
    }
    after |= before & (uint8_t)~value & WDIF; // write one to clear
    return reset_flag_set(w) ? (after | WDE) : after;
}

static void follow_interrupt(struct watchdog *w, uint64_t cycle)
{
    avr_int_vector_t *vector = &w->part->watchdog;
    bool wanted = (*control(w) & (WDIF | WDIE)) == (WDIF | WDIE);

    if (!wanted) {
        vector->pending = 0;
    } else if (!vector->pending) {
        set_flag(w, cycle);
    }
}

static void write_control(avr_t *avr, avr_io_addr_t address, uint8_t value, void *param)
{
    struct watchdog *w = param;
    uint64_t cycle = access_cycle(avr);
    bool opening = (value & (WDCE | WDE)) == (WDCE | WDE);
    bool may_change = cycle <= w->change_until && (value & WDCE) == 0;
    bool ran = runs(w);
    char text[64];

    avr->data[address] = written(w, value, may_change);
    w->change_until = opening ? cycle + WATCHDOG_CHANGE_TICKS : 0;
    if (!ran) {
        w->since = cycle + 1;
    }
    if (prescaler(w) > WDP_TOP) {
        (void)snprintf(
            text, sizeof text, "watchdog: WDP3:0 = %u is reserved", prescaler(w));
        w->hooks->refuse(w->hooks->board, text);
        return;
    }
    follow_interrupt(w, cycle + 1);
    schedule(w);
}

// simavr keeps what this returns in place of the register.
static uint8_t read_control(avr_t *avr, avr_io_addr_t address, void *param)
{
    const struct watchdog *w = param;

    return (uint8_t)((avr->data[address] & ~WDCE) |
                     (access_cycle(avr) <= w->change_until ? WDCE : 0U));
}

// "Executing the corresponding interrupt vector will clear WDIE and WDIF" (WDIF: simavr does).
static void on_running(struct avr_irq_t *irq, uint32_t value, void *param)
{
    const struct watchdog *w = param;

    (void)irq;
    if (value != 0 && (*control(w) & WDE) != 0) {
        *control(w) &= (uint8_t)~WDIE;
    }
}

void watchdog_reset(struct watchdog *w)
{
    *control(w) = reset_flag_set(w) ? WDE : 0;
    w->since = w->avr->cycle;
    w->change_until = 0;
    schedule(w);
}

static avr_watchdog_t *find_part(avr_t *avr)
{
    for (avr_io_t *io = avr->io_port; io != NULL; io = io->next) {
        if (strcmp(io->kind, "watchdog") == 0) {
            return (avr_watchdog_t *)(void *)io;
        }
    }
    (void)fputs("pixstep-sim: simavr's part has no watchdog\n", stderr);
    abort();
}

void watchdog_attach(struct watchdog *w, avr_t *avr, const struct watchdog_hooks *hooks)
{
    avr_watchdog_t *part = find_part(avr);

    memset(w, 0, sizeof *w);
    w->avr = avr;
    w->part = part;
    w->hooks = hooks;
    part->io.reset = NULL; // it would start its own timer
    access_take(avr, part->wdce.reg, read_control, write_control, w);
    avr_irq_register_notify(&part->watchdog.irq[AVR_INT_IRQ_RUNNING], on_running, w);
}
