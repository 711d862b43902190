// SPDX-License-Identifier: MIT

#include "irq_stats.h"

#include <stdio.h>
#include <string.h>

#include <avr_eeprom.h>
#include <avr_extint.h>
#include <avr_timer.h>
#include <avr_uart.h>
#include <avr_watchdog.h>

#include "access.h"

#define GPIOR1 0x4AU // data address, the same on all parts

static void name_vector(
    struct irq_stats *s, uint8_t vector, const char *unit, char which, const char *what)
{
    if (vector != 0 && vector < IRQ_VECTORS) {
        struct irq_vector_stats *v = &s->vector[vector];

        (void)snprintf(v->name, sizeof v->name, "%s%c_%s", unit, which, what);
    }
}

static void name_timer(struct irq_stats *s, const avr_timer_t *timer)
{
    name_vector(s, timer->overflow.vector, "TIMER", timer->name, "OVF");
    name_vector(s, timer->icr.vector, "TIMER", timer->name, "CAPT");
    name_vector(s, timer->comp[0].interrupt.vector, "TIMER", timer->name, "COMPA");
    name_vector(s, timer->comp[1].interrupt.vector, "TIMER", timer->name, "COMPB");
    name_vector(s, timer->comp[2].interrupt.vector, "TIMER", timer->name, "COMPC");
}

static void name_uart(struct irq_stats *s, const avr_uart_t *uart)
{
    name_vector(s, uart->rxc.vector, "USART", uart->name, "RX");
    name_vector(s, uart->udrc.vector, "USART", uart->name, "UDRE");
    name_vector(s, uart->txc.vector, "USART", uart->name, "TX");
}

static void name_whole(struct irq_stats *s, uint8_t vector, const char *name)
{
    if (vector != 0 && vector < IRQ_VECTORS) {
        (void)snprintf(s->vector[vector].name, sizeof s->vector[vector].name, "%s", name);
    }
}

static void name_extint(struct irq_stats *s, const avr_extint_t *extint)
{
    char name[] = "INT0";

    for (int i = 0; i < EXTINT_COUNT; i++) {
        name[3] = (char)('0' + i);
        name_whole(s, extint->eint[i].vector.vector, name);
    }
}

static void name_other(struct irq_stats *s, const avr_io_t *io)
{
    const void *module = io;

    if (strcmp(io->kind, "eeprom") == 0) {
        name_whole(s, ((const avr_eeprom_t *)module)->ready.vector, "EE_READY");
    } else if (strcmp(io->kind, "watchdog") == 0) {
        name_whole(s, ((const avr_watchdog_t *)module)->watchdog.vector, "WDT");
    } else if (strcmp(io->kind, "extint") == 0) {
        name_extint(s, module);
    }
}

static void name_vectors(struct irq_stats *s)
{
    for (int i = 0; i < IRQ_VECTORS; i++) {
        (void)snprintf(s->vector[i].name, sizeof s->vector[i].name, "VECTOR_%d", i);
    }
    for (const avr_io_t *io = s->avr->io_port; io != NULL; io = io->next) {
        if (strcmp(io->kind, "timer") == 0) {
            name_timer(s, (const avr_timer_t *)(const void *)io);
        } else if (strcmp(io->kind, "uart") == 0) {
            name_uart(s, (const avr_uart_t *)(const void *)io);
        } else {
            name_other(s, io);
        }
    }
}

void irq_stats_flag(struct irq_stats *s, uint8_t vector, uint64_t cycle)
{
    if (vector < IRQ_VECTORS) {
        s->vector[vector].flag_cycle = cycle;
        s->vector[vector].flagged = true;
    }
}

static void on_pending(struct avr_irq_t *irq, uint32_t value, void *param)
{
    struct irq_stats *s = param;
    uint8_t vector = (uint8_t)(irq->irq >> 8);

    // A model that knows the exact cycle has reported the flag just before.
    if (value != 0 && vector < IRQ_VECTORS && !s->vector[vector].flagged) {
        irq_stats_flag(s, vector, s->avr->cycle);
    }
}

static void begin_handler(struct irq_stats *s, uint8_t vector)
{
    struct irq_vector_stats *v = &s->vector[vector];
    uint64_t start = s->avr->cycle;

    if (v->flagged && start > v->flag_cycle && start - v->flag_cycle > v->latency_max) {
        v->latency_max = (uint32_t)(start - v->flag_cycle);
    }
    v->flagged = false;
    if (s->depth < IRQ_NESTING) {
        s->running[s->depth].vector = vector;
        s->running[s->depth].start = start;
        s->running[s->depth].nested = 0;
    }
    s->depth++;
    s->avr->cycle +=
        (s->avr->address_size > 2) ? IRQ_RESPONSE_22_BIT_PC : IRQ_RESPONSE_16_BIT_PC;
    if (s->woken) {
        s->avr->cycle += IRQ_RESPONSE_FROM_SLEEP;
        s->woken = false;
    }
}

static void add_handler(struct irq_vector_stats *v, uint32_t cycles)
{
    if (v->count == 0 || cycles < v->cycles_min) {
        v->cycles_min = cycles;
    }
    if (cycles > v->cycles_max) {
        v->cycles_max = cycles;
    }
    v->cycles_sum += cycles;
    v->count++;
}

// Called in the first cycle of RETI, which takes 4 cycles (5 with a 22-bit program counter).
static void end_handler(struct irq_stats *s)
{
    uint64_t end = s->avr->cycle + s->avr->address_size + 2U;
    uint64_t all;

    s->returned = true;
    if (s->depth == 0) {
        return;
    }
    s->depth--;
    if (s->depth >= IRQ_NESTING) {
        return;
    }
    all = end - s->running[s->depth].start;
    add_handler(&s->vector[s->running[s->depth].vector],
                (uint32_t)(all - s->running[s->depth].nested));
    if (s->depth > 0) {
        s->running[s->depth - 1].nested += all;
    } else {
        s->interrupt_cycles += all;
    }
}

static void on_running(struct avr_irq_t *irq, uint32_t value, void *param)
{
    struct irq_stats *s = param;

    if (value != 0) {
        begin_handler(s, (uint8_t)(irq->irq >> 8) & (IRQ_VECTORS - 1));
    } else {
        end_handler(s);
    }
}

static void note_longest(uint64_t *longest, uint64_t cycles)
{
    if (cycles > *longest) {
        *longest = cycles;
    }
}

// own_cycles: those of the main program so far.
static void enter_section(struct irq_stats *s, unsigned section, uint64_t own_cycles)
{
    if (s->section != s->calling) {
        note_longest(&s->section_longest[s->section], own_cycles - s->called_since);
    }
    if (section == IRQ_SECTION_CALLER) {
        s->section = s->calling;
        return;
    }
    s->section = (section < IRQ_SECTIONS) ? section : IRQ_SECTIONS - 1;
    s->section_entries[s->section]++;
    s->called_since = own_cycles;
    if (section == 0 || section > IRQ_SECTION_CALLED_LAST) {
        note_longest(&s->section_longest[s->calling], own_cycles - s->calling_since);
        s->calling = s->section;
        s->calling_since = own_cycles;
    }
}

static void write_gpior1(avr_t *avr, avr_io_addr_t address, uint8_t value, void *param)
{
    struct irq_stats *s = param;

    avr->data[address] = value;
    irq_stats_section(s, access_cycle(avr) + 1);
    enter_section(s, value, s->section_since - s->interrupt_cycles);
}

void irq_stats_attach(struct irq_stats *s, avr_t *avr)
{
    avr_int_table_t *table = &avr->interrupts;

    s->avr = avr;
    name_vectors(s);
    access_take(avr, GPIOR1, NULL, write_gpior1, s);
    for (int i = 0; i < table->vector_count; i++) {
        avr_int_vector_t *vector = table->vector[i];

        // The callback finds the vector's number in the number of simavr's IRQ.
        for (int j = 0; j < AVR_INT_IRQ_COUNT; j++) {
            vector->irq[j].irq = (uint32_t)vector->vector << 8 | (uint32_t)j;
        }
        avr_irq_register_notify(&vector->irq[AVR_INT_IRQ_PENDING], on_pending, s);
        avr_irq_register_notify(&vector->irq[AVR_INT_IRQ_RUNNING], on_running, s);
    }
}

void irq_stats_reset(struct irq_stats *s)
{
    s->depth = 0;
    s->woken = s->returned = false;
    s->section = s->calling = 0;
    s->section_since = s->avr->cycle;
    s->section_interrupts_since = s->interrupt_cycles;
    s->calling_since = s->called_since = s->section_since - s->interrupt_cycles;
    s->off = true;
    s->started = false;
    s->off_since = s->avr->cycle;
    for (int i = 0; i < IRQ_VECTORS; i++) {
        s->vector[i].flagged = false;
    }
}

void irq_stats_mark(struct irq_stats *s)
{
    for (int i = 0; i < IRQ_VECTORS; i++) {
        struct irq_vector_stats *v = &s->vector[i];

        v->count = 0;
        v->cycles_sum = 0;
        v->cycles_min = v->cycles_max = v->latency_max = 0;
    }
    s->off_max = s->off_main_max = 0;
    (void)memset(s->section_longest, 0, sizeof s->section_longest);
}

void irq_stats_section(struct irq_stats *s, uint64_t cycle)
{
    uint64_t interrupts = s->interrupt_cycles - s->section_interrupts_since;
    uint64_t all = cycle - s->section_since;

    s->section_cycles[s->section] += (all > interrupts) ? all - interrupts : 0;
    s->section_since = cycle;
    s->section_interrupts_since = s->interrupt_cycles;
}

// The program's start-up is over. Flags that came up before are counted from here: they waited for
// the start-up, not for a handler.
static void end_start_up(struct irq_stats *s)
{
    s->started = true;
    for (int i = 0; i < IRQ_VECTORS; i++) {
        s->vector[i].flag_cycle = s->avr->cycle;
    }
}

void irq_stats_i_bit(struct irq_stats *s, bool off)
{
    uint64_t cycle = s->avr->cycle;

    if (off) {
        s->off_since = cycle;
        s->off_in_main = s->depth == 0;
    } else if (!s->started) {
        end_start_up(s);
    } else {
        note_longest(&s->off_max, cycle - s->off_since);
        if (s->off_in_main) {
            note_longest(&s->off_main_max, cycle - s->off_since);
        }
    }
    s->off = off;
}
