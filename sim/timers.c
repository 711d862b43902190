// SPDX-License-Identifier: MIT

#include "timers.h"

#include <stddef.h>

#include <avr_ioport.h>

#include "access.h"
#include "peripheral.h"

#define GTCCR      0x43U // data address, the same on all parts
#define GTCCR_TSM  0x80U
#define GTCCR_SYNC 0x01U // PSRSYNC: the prescaler of timers 0, 1, 3, 4, 5
#define GTCCR_MASK 0x83U

// TSM keeps PSRSYNC as written and with it the timers halted; without TSM the bit clears itself.
static void write_gtccr(avr_t *avr, avr_io_addr_t address, uint8_t value, void *param)
{
    struct timers *t = param;
    bool tsm = (value & GTCCR_TSM) != 0;
    uint64_t cycle = access_cycle(avr) + 1;

    avr->data[address] = tsm ? (value & GTCCR_MASK) : 0;
    for (int i = 0; i < t->count; i++) {
        timer16_hold(&t->timer[i], tsm && (value & GTCCR_SYNC) != 0, cycle);
    }
}

static void find_icp(struct timers *t, int timer)
{
    const avr_regbit_t icp = t->timer[timer].part->icp;

    for (avr_io_t *io = peripheral_next(t->avr->io_port, "port"); io != NULL;
         io = peripheral_next(io->next, "port")) {
        const avr_ioport_t *port = (const avr_ioport_t *)(const void *)io;

        if (icp.reg == port->r_port || icp.reg == port->r_pin) {
            t->icp[timer].port = port->name;
            t->icp[timer].bit = (uint8_t)icp.bit;
        }
    }
}

void timers_attach(struct timers *t, avr_t *avr, const struct timer16_hooks *hooks)
{
    t->avr = avr;
    for (avr_io_t *io = peripheral_next(avr->io_port, "timer"); io != NULL;
         io = peripheral_next(io->next, "timer")) {
        avr_timer_t *part = (avr_timer_t *)(void *)io;

        if (timer16_is_16_bit(part) && t->count < TIMERS_MOST) {
            timer16_attach(&t->timer[t->count], avr, part, hooks);
            find_icp(t, t->count);
            t->count++;
        }
    }
    access_take(avr, GTCCR, NULL, write_gtccr, t);
}

void timers_reset(struct timers *t)
{
    for (int i = 0; i < t->count; i++) {
        timer16_reset(&t->timer[i]);
    }
}

void timers_sync(struct timers *t, uint64_t cycle)
{
    for (int i = 0; i < t->count; i++) {
        timer16_sync(&t->timer[i], cycle);
    }
}

struct timer16 *timers_by_name(struct timers *t, char name)
{
    for (int i = 0; i < t->count; i++) {
        if (t->timer[i].name == name) {
            return &t->timer[i];
        }
    }
    return NULL;
}
