// SPDX-License-Identifier: MIT
//
// The program's view of a 16-bit timer: 16-bit access through TEMP, the flags, the control
// registers.
//
// An access in cycle a: reads see everything up to a; writes take effect from a + 1 on, after
// what happens in that very step (a buffer written in the last cycle of a period is loaded a
// period later).

#include "timer16.h"

#include <stddef.h>

#include <sim_regbit.h>

#include "access.h"

#define FORCE_COMPARE_BITS 0xE0U // FOCnA, FOCnB, FOCnC in TCCRnC
#define IS_PWM_MODE(mode)  ((mode) != 0 && (mode) != 4 && (mode) != 12)

static avr_int_vector_t *vector_of(struct timer16 *t, int index)
{
    switch (index) {
    case 0:
        return &t->part->overflow;
    case 1:
        return &t->part->icr;
    default:
        return &t->part->comp[index - 2].interrupt;
    }
}

#define VECTORS (2 + TIMER16_CHANNELS)

static int channel_of(const struct timer16 *t, avr_io_addr_t address)
{
    for (int i = 0; i < TIMER16_CHANNELS; i++) {
        if (address == t->part->comp[i].r_ocr || address == t->part->comp[i].r_ocrh) {
            return i;
        }
    }
    return 0;
}

// Reports every output whose connection may have changed.
static void report_outputs(struct timer16 *t, uint64_t cycle)
{
    for (int i = 0; i < TIMER16_CHANNELS; i++) {
        t->hooks->output(t->hooks->host.board, t, i, cycle);
    }
}

static void write_tccra(avr_t *avr, avr_io_addr_t address, uint8_t value, void *param)
{
    struct timer16 *t = param;
    uint64_t cycle = access_cycle(avr) + 1;

    timer16_sync(t, cycle);
    avr->data[address] = value;
    t->tccra = value;
    timer16_control_changed(t, cycle);
    report_outputs(t, cycle);
}

static void write_tccrb(avr_t *avr, avr_io_addr_t address, uint8_t value, void *param)
{
    struct timer16 *t = param;
    uint64_t cycle = access_cycle(avr) + 1;

    timer16_sync(t, cycle);
    avr->data[address] = value;
    t->tccrb = value;
    timer16_control_changed(t, cycle);
}

static void write_tccrc(avr_t *avr, avr_io_addr_t address, uint8_t value, void *param)
{
    struct timer16 *t = param;

    avr->data[address] = 0; // reads as zero
    if ((value & FORCE_COMPARE_BITS) != 0) {
        peripheral_refuse(
            &t->hooks->host, "timer %c: force compare is not modelled", t->name);
    }
}

static void write_high(avr_t *avr, avr_io_addr_t address, uint8_t value, void *param)
{
    struct timer16 *t = param;

    (void)avr;
    (void)address;
    t->temp = value;
}

static void write_tcnt_low(avr_t *avr, avr_io_addr_t address, uint8_t value, void *param)
{
    struct timer16 *t = param;
    uint64_t cycle = access_cycle(avr) + 1;

    (void)address;
    timer16_sync(t, cycle);
    timer16_set_count(t, (uint16_t)(t->temp << 8 | value), cycle);
}

static void write_ocr_low(avr_t *avr, avr_io_addr_t address, uint8_t value, void *param)
{
    struct timer16 *t = param;
    uint64_t cycle = access_cycle(avr) + 1;
    int channel = channel_of(t, address);

    timer16_sync(t, cycle);
    t->ocr_buffer[channel] = (uint16_t)(t->temp << 8 | value);
    if (!IS_PWM_MODE(timer16_mode(t))) {
        t->ocr[channel] = t->ocr_buffer[channel];
        timer16_compare_changed(t, channel, cycle);
    }
}

// ICRn can be written only in the modes that have it as TOP, none of which is modelled.
static void write_icr_low(avr_t *avr, avr_io_addr_t address, uint8_t value, void *param)
{
    (void)avr;
    (void)address;
    (void)value;
    (void)param;
}

static uint8_t read_tcnt_low(avr_t *avr, avr_io_addr_t address, void *param)
{
    struct timer16 *t = param;
    uint64_t cycle = access_cycle(avr);
    uint16_t count;

    (void)address;
    timer16_sync(t, cycle);
    count = timer16_count(t, cycle);
    t->temp = (uint8_t)(count >> 8);
    return (uint8_t)count;
}

static uint8_t read_icr_low(avr_t *avr, avr_io_addr_t address, void *param)
{
    struct timer16 *t = param;

    (void)address;
    timer16_sync(t, access_cycle(avr));
    t->temp = (uint8_t)(t->icr >> 8);
    return (uint8_t)t->icr;
}

static uint8_t read_high(avr_t *avr, avr_io_addr_t address, void *param)
{
    struct timer16 *t = param;

    (void)avr;
    (void)address;
    return t->temp;
}

static uint8_t read_ocr(avr_t *avr, avr_io_addr_t address, void *param)
{
    struct timer16 *t = param;
    int channel = channel_of(t, address);
    bool high = address == t->part->comp[channel].r_ocrh;

    (void)avr;
    return (uint8_t)(t->ocr_buffer[channel] >> (high ? 8 : 0));
}

static uint8_t read_tifr(avr_t *avr, avr_io_addr_t address, void *param)
{
    timer16_sync(param, access_cycle(avr));
    return avr->data[address];
}

// Write one to clear. A flag that is set in the step after the write stays set.
static void write_tifr(avr_t *avr, avr_io_addr_t address, uint8_t value, void *param)
{
    struct timer16 *t = param;
    uint8_t cleared = access_flags_written(avr, value);

    timer16_sync(t, access_cycle(avr));
    avr->data[address] &= (uint8_t)~cleared;
    for (int i = 0; i < VECTORS; i++) {
        avr_int_vector_t *vector = vector_of(t, i);

        if (vector->vector != 0 && (cleared & (1U << vector->raised.bit)) != 0) {
            avr_clear_interrupt(avr, vector);
        }
    }
}

// simavr raises an interrupt only if it is enabled when its flag comes up. Here an interrupt whose
// flag waited is raised, and one that is disabled while it waits is withdrawn (its flag stays).
static void write_timsk(avr_t *avr, avr_io_addr_t address, uint8_t value, void *param)
{
    struct timer16 *t = param;

    timer16_sync(t, access_cycle(avr));
    avr->data[address] = value;
    for (int i = 0; i < VECTORS; i++) {
        avr_int_vector_t *vector = vector_of(t, i);

        if (vector->vector == 0) {
            continue;
        }
        if ((value & (1U << vector->enable.bit)) == 0) {
            vector->pending = 0;
        } else if (avr_regbit_get(avr, vector->raised) != 0 && !vector->pending) {
            peripheral_raise(&t->hooks->host, avr, vector, access_cycle(avr) + 1);
        }
    }
    timer16_schedule(t); // a match may have an effect now
}

static void take_registers(struct timer16 *t)
{
    avr_t *avr = t->avr;
    const avr_timer_t *part = t->part;
    avr_io_addr_t tccrb = part->cs[0].reg;

    access_take(avr, part->wgm[0].reg, NULL, write_tccra, t);
    access_take(avr, tccrb, NULL, write_tccrb, t);
    access_take(avr, (avr_io_addr_t)(tccrb + 1U), NULL, write_tccrc, t);
    access_take(avr, part->r_tcnt, read_tcnt_low, write_tcnt_low, t);
    access_take(avr, part->r_tcnth, read_high, write_high, t);
    access_take(avr, part->r_icr, read_icr_low, write_icr_low, t);
    access_take(avr, part->r_icrh, read_high, write_high, t);
    for (int i = 0; i < TIMER16_CHANNELS; i++) {
        if (part->comp[i].r_ocr != 0) { // the ATmega328P has no channel C
            access_take(avr, part->comp[i].r_ocr, read_ocr, write_ocr_low, t);
            access_take(avr, part->comp[i].r_ocrh, read_ocr, write_high, t);
        }
    }
    access_take(avr, part->overflow.raised.reg, read_tifr, write_tifr, t);
    access_take(avr, part->overflow.enable.reg, NULL, write_timsk, t);
}

bool timer16_is_16_bit(const avr_timer_t *part)
{
    return part->r_tcnth != 0;
}

void timer16_attach(struct timer16 *t,
                    avr_t *avr,
                    avr_timer_t *part,
                    const struct timer16_hooks *hooks)
{
    t->avr = avr;
    t->part = part;
    t->hooks = hooks;
    t->name = part->name;
    t->icp_level = t->icp_lasting = false;
    t->icp_cycle = 0;
    // Where ICRn is TOP, simavr's own input capture does nothing: otherwise each edge would
    // interrupt twice.
    part->mode.top = avr_timer_wgm_reg_icr;
    timer16_reset(t);
    take_registers(t);
}
